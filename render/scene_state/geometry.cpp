#include "render/scene_state/geometry.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <tuple>

#include "render/scene_state/geometry_edit.h"
#include "scenes/error.h"
#include "scenes/parallel.h"
#include "scenes/subdivision.h"

namespace maquette {
namespace {

/// Source and destination of one item.
struct Instance {
  const Primitive* source = nullptr;
  glm::mat4 world_from_node{1.0f};
  TextureRef mapped;  ///< whose coordinates tangents follow
  DrawItem item;
};

/// Magnitude of the handedness of tangents that the file gave: textures with coordinates of their own use these too.
constexpr double kOfFile = 2.0;
constexpr glm::dvec3 kUp(0.0, 1.0, 0.0);

glm::dvec3 normalize_or(const glm::dvec3& v, const glm::dvec3& fallback) {
  const double length = glm::length(v);
  return length > 0.0 && std::isfinite(length) ? v / length : fallback;
}

/// Any unit vector perpendicular to the unit vector `n`.
/// Source: Duff et al. 2017, Building an Orthonormal Basis, Revisited, listing 3.
glm::dvec3 any_tangent(const glm::dvec3& n) {
  const double sign = std::copysign(1.0, n.z);
  const double a = -1.0 / (sign + n.z);
  return {1.0 + sign * n.x * n.x * a, sign * n.x * n.y * a, -sign * n.x};
}

/// Writes one instance into its ranges of the shared arrays; ranges of different instances never overlap.
class InstanceWriter {
 public:
  InstanceWriter(const Instance& instance, FlatGeometry* out)
      : source_(*instance.source),
        world_(instance.world_from_node),
        linear_(instance.world_from_node),
        mirrored_(glm::determinant(linear_) < 0.0),
        mapped_(instance.mapped),
        item_(instance.item),
        out_(*out) {}

  void write() {
    write_positions();
    write_indices();
    write_normals();
    copy_or_fill(source_.uvs[0], glm::vec2(0.0f), &out_.uv0);
    copy_or_fill(source_.uvs[1], glm::vec2(0.0f), &out_.uv1);
    copy_or_fill(source_.colors, glm::vec4(1.0f), &out_.colors);
    write_tangents();
  }

 private:
  std::size_t vertex(std::size_t i) const { return item_.first_vertex + i; }
  std::size_t vertex_count() const { return item_.vertex_count; }

  void write_positions() {
    for (std::size_t i = 0; i < vertex_count(); ++i)
      out_.positions[vertex(i)] = glm::vec3(world_ * glm::vec4(source_.positions[i], 1.0f));
  }

  void write_indices() {
    std::uint32_t* target = out_.indices.data() + item_.first_index;
    for (std::size_t i = 0; i < item_.index_count; i += 3) {
      const std::uint32_t* t = source_.indices.data() + i;
      target[i] = item_.first_vertex + t[0];
      target[i + 1] = item_.first_vertex + (mirrored_ ? t[2] : t[1]);
      target[i + 2] = item_.first_vertex + (mirrored_ ? t[1] : t[2]);
    }
  }

  /// Cofactor matrix instead of the inverse transpose: it exists for a singular scale too.
  glm::dmat3 normal_matrix() const {
    const glm::dmat3& m = linear_;
    const glm::dmat3 cofactors(glm::cross(m[1], m[2]), glm::cross(m[2], m[0]), glm::cross(m[0], m[1]));
    return mirrored_ ? -cofactors : cofactors;
  }

  void write_normals() {
    bool complete = !source_.normals.empty();
    const glm::dmat3 matrix = normal_matrix();
    for (std::size_t i = 0; i < source_.normals.size(); ++i) {
      const glm::dvec3 normal = normalize_or(matrix * glm::dvec3(source_.normals[i]), glm::dvec3(0.0));
      out_.normals[vertex(i)] = glm::vec3(normal);
      complete = complete && normal != glm::dvec3(0.0);
    }
    if (!complete) fill_missing_normals();
  }

  /// Sum of the cross products of the triangles around a vertex: the mean of their normals weighted by area.
  void fill_missing_normals() {
    std::vector<glm::dvec3> sums(vertex_count(), glm::dvec3(0.0));
    for_each_triangle([&](const std::uint32_t* t, const glm::dvec3* p) {
      const glm::dvec3 cross = glm::cross(p[1] - p[0], p[2] - p[0]);
      for (int corner = 0; corner < 3; ++corner) sums[t[corner] - item_.first_vertex] += cross;
    });
    for (std::size_t i = 0; i < vertex_count(); ++i)
      if (source_.normals.empty() || out_.normals[vertex(i)] == glm::vec3(0.0f))
        out_.normals[vertex(i)] = glm::vec3(normalize_or(sums[i], kUp));
  }

  void write_tangents() {
    if (!source_.tangents.empty()) {
      for (std::size_t i = 0; i < vertex_count(); ++i) {
        const glm::dvec3 tangent = linear_ * glm::dvec3(source_.tangents[i]);
        const double handedness = (source_.tangents[i].w < 0.0f) != mirrored_ ? -kOfFile : kOfFile;
        set_tangent(i, tangent, handedness);
      }
    } else if (!source_.uvs[static_cast<std::size_t>(mapped_.uv_set)].empty()) {
      write_tangents_from_uvs(mapped_.uv_set == 0 ? out_.uv0 : out_.uv1);
    } else {
      for (std::size_t i = 0; i < vertex_count(); ++i) set_tangent(i, glm::dvec3(0.0), 1.0);
    }
  }

  /// Direction of growing u of the normal texture, averaged over the triangles around a vertex. The bitangent
  /// points to the top of the texture, where v is 0: the green of a normal map is up (glTF 2.0, 3.9.3).
  /// Source: Lengyel 2001, Computing Tangent Space Basis Vectors for an Arbitrary Mesh.
  void write_tangents_from_uvs(const std::vector<glm::vec2>& uvs) {
    std::vector<glm::dvec3> along_u(vertex_count(), glm::dvec3(0.0)), along_v(vertex_count(), glm::dvec3(0.0));
    for_each_triangle([&](const std::uint32_t* t, const glm::dvec3* p) {
      const glm::dvec2 uv0(uvs[t[0]]), s(transformed(glm::dvec2(uvs[t[1]]) - uv0)),
          r(transformed(glm::dvec2(uvs[t[2]]) - uv0));
      const double area = s.x * r.y - r.x * s.y;
      if (area == 0.0) return;
      const glm::dvec3 e1 = p[1] - p[0], e2 = p[2] - p[0];
      const double sign = area < 0.0 ? -1.0 : 1.0;  // the length is kept as an area weight in world space
      for (int corner = 0; corner < 3; ++corner) {
        along_u[t[corner] - item_.first_vertex] += sign * (e1 * r.y - e2 * s.y);
        along_v[t[corner] - item_.first_vertex] += sign * (e2 * s.x - e1 * r.x);
      }
    });
    for (std::size_t i = 0; i < vertex_count(); ++i) {
      const glm::dvec3 normal(out_.normals[vertex(i)]);
      const double handedness = glm::dot(glm::cross(normal, along_u[i]), along_v[i]) > 0.0 ? -1.0 : 1.0;
      set_tangent(i, along_u[i], handedness);
    }
  }

  /// By the linear part of KHR_texture_transform.
  glm::dvec2 transformed(const glm::dvec2& uv) const {
    const glm::dvec2 scaled = glm::dvec2(mapped_.scale) * uv;
    const double c = std::cos(static_cast<double>(mapped_.rotation_rad));
    const double s = std::sin(static_cast<double>(mapped_.rotation_rad));
    return {c * scaled.x + s * scaled.y, c * scaled.y - s * scaled.x};
  }

  void set_tangent(std::size_t i, const glm::dvec3& tangent, double handedness) {
    const glm::dvec3 normal(out_.normals[vertex(i)]);
    const glm::dvec3 unit = normalize_or(tangent, glm::dvec3(0.0));
    const glm::dvec3 across = unit - glm::dot(unit, normal) * normal;
    constexpr double kParallel = 1e-6;  // a tangent along the normal is useless
    const glm::dvec3 direction = glm::length(across) > kParallel ? glm::normalize(across) : any_tangent(normal);
    out_.tangents[vertex(i)] = glm::vec4(glm::vec3(direction), static_cast<float>(handedness));
  }

  template <typename Visit>
  void for_each_triangle(const Visit& visit) const {
    for (std::size_t i = 0; i < item_.index_count; i += 3) {
      const std::uint32_t* t = out_.indices.data() + item_.first_index + i;
      const glm::dvec3 points[3] = {glm::dvec3(out_.positions[t[0]]), glm::dvec3(out_.positions[t[1]]),
                                    glm::dvec3(out_.positions[t[2]])};
      visit(t, points);
    }
  }

  template <typename T>
  void copy_or_fill(const std::vector<T>& values, const T& fallback, std::vector<T>* target) {
    const auto first = target->begin() + item_.first_vertex;
    if (values.empty()) {
      std::fill_n(first, vertex_count(), fallback);
    } else {
      std::copy_n(values.begin(), vertex_count(), first);
    }
  }

  const Primitive& source_;
  glm::mat4 world_{1.0f};
  glm::dmat3 linear_{1.0};
  bool mirrored_;
  TextureRef mapped_;
  DrawItem item_;
  FlatGeometry& out_;
};

// What buffers of common drivers address (2^27 texels, of a vertex four), and parts of which each takes a kilobyte.
constexpr std::size_t kMostVertices = std::size_t{1} << 25, kMostIndices = std::size_t{1} << 27, kMostItems = 1'000'000;

/// The normal texture, or the coat's where the material has no other. Tangents are the same in all variants: the first
/// material with such a texture counts. Source: glTF 2.0, 3.7.2.1: tangents of the texture coordinates associated with
/// the normal texture; KHR_texture_transform transforms these.
TextureRef mapped_texture(const Scene& scene, const Primitive& primitive) {
  std::vector<int> candidates = {primitive.material};
  for (const auto& [variant, material] : primitive.variant_materials) candidates.push_back(material);
  for (const int index : candidates) {
    if (index < 0 || index >= static_cast<int>(scene.materials.size())) continue;
    const Material& material = scene.materials[static_cast<std::size_t>(index)];
    for (const TextureRef* texture :
         {&material.normal_texture, &material.clearcoat_normal_texture, &material.anisotropy_texture})
      if (*texture) return *texture;
  }
  return {};
}

std::vector<Instance> collect_instances(const Scene& scene, const std::vector<Primitive>& patches) {
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  std::vector<Instance> instances;
  for (std::size_t n = 0; n < scene.nodes.size(); ++n) {
    const Node& node = scene.nodes[n];
    if (!node.visible) continue;
    Instance instance;
    instance.world_from_node = world[n];
    instance.item.node = static_cast<int>(n);
    instance.item.scale = std::cbrt(std::abs(glm::determinant(glm::mat3(world[n]))));
    if (node.mesh >= 0) {
      const Mesh& mesh = scene.meshes[static_cast<std::size_t>(node.mesh)];
      instance.item.mesh = node.mesh;
      for (std::size_t p = 0; p < mesh.primitives.size(); ++p) {
        instance.item.primitive = static_cast<int>(p);
        instance.source = &mesh.primitives[p];
        instance.mapped = mapped_texture(scene, mesh.primitives[p]);
        instances.push_back(instance);
      }
    }
    if (node.patch >= 0) {
      instance.item.mesh = instance.item.primitive = -1;
      instance.item.patch = node.patch;
      instance.source = &patches[static_cast<std::size_t>(node.patch)];
      instance.mapped = {};
      instances.push_back(instance);
    }
  }
  return instances;
}

}  // namespace

const DrawItem& item_of_triangle(const FlatGeometry& geometry, std::uint32_t triangle) {
  const auto next =
      std::upper_bound(geometry.items.begin(), geometry.items.end(), 3 * triangle,
                       [](std::uint32_t index, const DrawItem& item) { return index < item.first_index; });
  return *std::prev(next);
}

bool is_closed(const FlatGeometry& geometry, const DrawItem& item) {
  std::vector<glm::vec3> corners;
  for (const DrawItem& other : geometry.items) {
    const bool same = item.node >= 0 ? other.node == item.node : &other == &item;
    for (std::uint32_t k = 0; same && k < other.index_count; ++k)
      corners.push_back(geometry.positions[geometry.indices[other.first_index + k]]);
  }
  const auto less = [](const glm::vec3& a, const glm::vec3& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  };
  std::vector<glm::vec3> places = corners;
  std::ranges::sort(places, less);
  places.erase(std::unique(places.begin(), places.end()), places.end());
  const auto number_of = [&](const glm::vec3& p) {
    return static_cast<std::uint32_t>(std::ranges::lower_bound(places, p, less) - places.begin());
  };
  std::vector<std::pair<std::uint32_t, std::uint32_t>> edges, reversed;
  for (std::size_t k = 0; k + 2 < corners.size(); k += 3) {
    const std::uint32_t v[] = {number_of(corners[k]), number_of(corners[k + 1]), number_of(corners[k + 2])};
    if (v[0] == v[1] || v[1] == v[2] || v[2] == v[0]) continue;  // has no area
    for (int e = 0; e < 3; ++e) {
      edges.emplace_back(v[e], v[(e + 1) % 3]);
      reversed.emplace_back(v[(e + 1) % 3], v[e]);
    }
  }
  std::ranges::sort(edges);
  std::ranges::sort(reversed);
  return edges == reversed;
}

FlatGeometry flatten(const Scene& scene) {
  const auto require = [&](std::size_t count, std::size_t most, const char* what) {
    if (count > most)
      throw Error(scene.name,
                  "has more than " + std::to_string(most / 1'000'000) + " million " + what + " with all its instances",
                  "hide some nodes, or make them lighter");
  };
  std::vector<Primitive> patches;
  std::size_t of_patches = 0;
  for (const BezierPatch& patch : scene.patches) {
    patches.push_back(tessellate_patch(patch, patch_sides(patch)));
    require(of_patches += patches.back().positions.size(), kMostVertices / 4, "vertices of patches");
  }
  std::vector<Instance> instances = collect_instances(scene, patches);
  require(instances.size(), kMostItems, "parts");

  std::size_t vertex_count = 0, index_count = 0;
  FlatGeometry out;
  for (Instance& instance : instances) {
    instance.item.first_vertex = static_cast<std::uint32_t>(vertex_count);
    instance.item.first_index = static_cast<std::uint32_t>(index_count);
    instance.item.vertex_count = static_cast<std::uint32_t>(instance.source->positions.size());
    instance.item.index_count = static_cast<std::uint32_t>(instance.source->indices.size() / 3 * 3);
    vertex_count += instance.source->positions.size();
    index_count += instance.item.index_count;
    require(vertex_count, kMostVertices, "vertices");
    require(index_count, kMostIndices, "indices");
    out.items.push_back(instance.item);
  }
  out.positions.resize(vertex_count);
  out.normals.resize(vertex_count);
  out.tangents.resize(vertex_count);
  out.uv0.resize(vertex_count);
  out.uv1.resize(vertex_count);
  out.colors.resize(vertex_count);
  out.indices.resize(index_count);
  parallel_for(std::size_t{0}, instances.size(), [&](std::size_t i) { InstanceWriter(instances[i], &out).write(); });
  return out;
}

void write_item(const Scene& scene, const Primitive& primitive, const glm::mat4& world_from_node, const DrawItem& item,
                FlatGeometry* geometry) {
  InstanceWriter({&primitive, world_from_node, mapped_texture(scene, primitive), item}, geometry).write();
}

}  // namespace maquette
