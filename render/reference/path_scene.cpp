#include "render/reference/path_scene.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <set>
#include <span>

#include "render/btf/btf_source.h"
#include "render/environment/texel_cell.h"
#include "render/reference/traced_environment.h"
#include "render/reference/traversal.h"
#include "render/reference/triangle_pairs.h"
#include "render/scene_state/material_overrides.h"
#include "scenes/error.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

std::shared_ptr<const MeasuredMaterial> load_measured(const std::string& source) {
  auto material = std::make_shared<MeasuredMaterial>();
  if (is_btf_source(source)) {
    material->btf = load_btf(source);
    return material;
  }
  const BrdfTable table = load_brdf(source);
  material->values = PackedBrdf(table);
  material->tables = load_brdf_tables(table);
  return material;
}

/// What is kept of a source: another entry once its file is another.
std::string measured_name(const std::string& source) {
  return source + " " + std::to_string(material_source_stamp(source));
}

/// In parallel: much of the time of each is reading.
void load_measured(const std::vector<Material>& materials, MeasuredLibrary* library) {
  std::set<std::string> missing;
  for (const Material& m : materials)
    if (!m.measured.empty() && !library->contains(measured_name(m.measured))) missing.insert(m.measured);
  const std::vector<std::string> sources(missing.begin(), missing.end());
  std::vector<std::shared_ptr<const MeasuredMaterial>> loaded(sources.size());
  parallel_for(std::size_t{0}, sources.size(), [&](std::size_t i) { loaded[i] = load_measured(sources[i]); });
  for (std::size_t i = 0; i < sources.size(); ++i) (*library)[measured_name(sources[i])] = std::move(loaded[i]);
}

TracedMaterial make_material(const Material& values, const TextureAtlas& atlas, std::size_t index,
                             const MeasuredLibrary& library) {
  TracedMaterial m;
  m.values = values;
  m.textures.fill(-1);
  for (std::size_t k = 0; k < kTextureRoles && index < atlas.of_material.size(); ++k) {
    if (texture_of(values, static_cast<TextureRole>(k))) m.textures[k] = atlas.of_material[index][k];
    m.textured |= m.textures[k] >= 0;
  }
  if (!values.measured.empty()) {
    const std::shared_ptr<const MeasuredMaterial>& table = library.at(measured_name(values.measured));
    m.btf = table->btf;
    if (!m.btf) m.measured = table;
  }
  m.pane = pane_share(values);
  m.solid = m.pane > 0.0f && values.thickness > 0.0f;
  m.rough = m.pane > 0.0f && values.roughness * values.roughness > shared::kMinAlpha;
  // Source: KHR_materials_volume: color^(distance / attenuation distance).
  m.absorption = -glm::log(glm::max(values.attenuation_color, glm::vec3(1e-20f))) / values.attenuation_distance;
  m.own_coat_tangents = has_own_coat_tangents(values);
  m.blended = values.alpha_mode == AlphaMode::blend;
  m.masked = values.alpha_mode == AlphaMode::mask &&
             (m.texture(TextureRole::base_color) >= 0 || values.base_color.a < values.alpha_cutoff);
  return m;
}

/// A BTF has a scale of its own: texture coordinates only say how it runs over the surface.
void measure_uvs(PathScene* scene) {
  const bool any = std::any_of(scene->materials.begin(), scene->materials.end(), [](const auto& m) { return m.btf; });
  if (!any) return;
  const FlatGeometry& g = scene->geometry;
  scene->metres_per_uv.assign(g.indices.size() / 3, 0.0f);
  for (const DrawItem& item : g.items) {
    double area = 0.0, of_uvs = 0.0;
    for (std::uint32_t i = item.first_index; i < item.first_index + item.index_count; i += 3) {
      const std::uint32_t* c = &g.indices[i];
      const glm::dvec3 p(g.positions[c[0]]), e1 = glm::dvec3(g.positions[c[1]]) - p,
                                             e2 = glm::dvec3(g.positions[c[2]]) - p;
      const glm::dvec2 q(g.uv0[c[0]]), s = glm::dvec2(g.uv0[c[1]]) - q, t = glm::dvec2(g.uv0[c[2]]) - q;
      area += glm::length(glm::cross(e1, e2));
      of_uvs += std::abs(s.x * t.y - t.x * s.y);
    }
    const double side = of_uvs > 0.0 ? std::sqrt(area / of_uvs) : 0.0;
    std::fill_n(scene->metres_per_uv.begin() + item.first_index / 3, item.index_count / 3,
                std::isfinite(side) ? static_cast<float>(side) : 0.0f);
  }
}

int material_index(const Scene& scene, const DrawItem& item, int variant) {
  const int index =
      item.patch >= 0
          ? scene.patches[static_cast<std::size_t>(item.patch)].material
          : material_of(
                scene.meshes[static_cast<std::size_t>(item.mesh)].primitives[static_cast<std::size_t>(item.primitive)],
                variant);
  const int count = static_cast<int>(scene.materials.size());
  return index < 0 || index > count ? count : index;
}

/// Squares of tiny edges underflow: takes the cross product of edges scaled by their largest coordinate.
glm::vec3 unit_cross(const glm::vec3& e1, const glm::vec3& e2) {
  const float scale = std::max(shared::light_largest(e1), shared::light_largest(e2));
  const glm::vec3 c = scale > 0.0f ? glm::cross(e1 / scale, e2 / scale) : glm::vec3(0.0f);
  const float length = glm::length(c);
  return length > 0.0f ? c / length : glm::vec3(0.0f, 1.0f, 0.0f);
}

/// Material of every triangle of the geometry, with the flag kBothSides, and the triangles of each mesh of the ray
/// tracer, hidden ones last.
struct Assignment {
  std::vector<std::uint32_t> materials;
  std::array<std::vector<std::uint32_t>, PathScene::kHidden + 1> meshes;
};

Assignment assign_triangles(const PathSceneInput& input, PathScene* scene) {
  Assignment assignment;
  assignment.materials.assign(scene->geometry.indices.size() / 3, 0);
  for (const DrawItem& item : scene->geometry.items) {
    const auto material = static_cast<std::uint32_t>(material_index(input.scene, item, input.variant));
    const bool visible = item.node < 0 || input.scene.nodes[static_cast<std::size_t>(item.node)].visible;
    TracedMaterial& m = scene->materials[material];
    const std::span<const glm::vec4> colors(scene->geometry.colors.data() + item.first_vertex, item.vertex_count);
    m.colored |= std::any_of(colors.begin(), colors.end(), [](const auto& c) { return c != glm::vec4(1.0f); });
    m.masked |= m.colored && m.values.alpha_mode == AlphaMode::mask;
    const std::uint32_t sides = m.values.double_sided || item.patch >= 0 ? kBothSides : 0u;
    const std::size_t mesh = !visible                ? PathScene::kHidden
                             : m.masked || m.blended ? PathScene::kAlpha
                             : m.clear() > 0.0f      ? PathScene::kPanes
                                                     : PathScene::kOpaque;
    for (std::uint32_t i = item.first_index / 3; i < (item.first_index + item.index_count) / 3; ++i) {
      assignment.materials[i] = material | sides;
      assignment.meshes[mesh].push_back(i);
    }
    for (std::uint32_t v = item.first_vertex; visible && v < item.first_vertex + item.vertex_count; ++v) {
      scene->bounds.min = glm::min(scene->bounds.min, scene->geometry.positions[v]);
      scene->bounds.max = glm::max(scene->bounds.max, scene->geometry.positions[v]);
    }
  }
  return assignment;
}

TracedTriangle traced_triangle(const FlatGeometry& geometry, std::uint32_t source, std::uint32_t material) {
  TracedTriangle t;
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t corner = geometry.indices[3 * static_cast<std::size_t>(source) + k];
    t.positions[k] = geometry.positions[corner];
    t.normals[k] = geometry.normals[corner];
  }
  t.geometric = unit_cross(t.positions[1] - t.positions[0], t.positions[2] - t.positions[0]);
  t.material = material;
  t.source = source;
  return t;
}

/// Below this share of paired triangles, the fourth corners take more memory than the pairs save.
constexpr double kLeastPaired = 0.5;

/// Orders the triangles of the meshes by pairs, where there are enough of them.
void pair_meshes(std::array<std::vector<std::uint32_t>, PathScene::kHidden + 1>* meshes, PathScene* scene) {
  std::vector<std::uint32_t> rotated = scene->geometry.indices;
  std::array<TrianglePairs, PathScene::kHidden> pairs;
  double count = 0.0, paired = 0.0;
  for (std::size_t mesh = 0; mesh < PathScene::kHidden; ++mesh) {
    pairs[mesh] = pair_triangles((*meshes)[mesh], scene->geometry.positions, rotated);
    count += static_cast<double>((*meshes)[mesh].size());
    paired += 2.0 * pairs[mesh].pair_count;
  }
  scene->quads = paired > kLeastPaired * count;
  if (!scene->quads) return;
  scene->geometry.indices = std::move(rotated);
  for (std::size_t mesh = 0; mesh < PathScene::kHidden; ++mesh) {
    scene->pair_count[mesh] = pairs[mesh].pair_count;
    (*meshes)[mesh] = std::move(pairs[mesh].order);
  }
}

void gather_triangles(const PathSceneInput& input, PathScene* scene) {
  Assignment assignment = assign_triangles(input, scene);
  pair_meshes(&assignment.meshes, scene);
  std::vector<std::uint32_t> order;
  for (std::size_t mesh = 0; mesh < assignment.meshes.size(); ++mesh) {
    scene->mesh_begin[mesh] = static_cast<std::uint32_t>(order.size());
    order.insert(order.end(), assignment.meshes[mesh].begin(), assignment.meshes[mesh].end());
  }
  scene->triangles.resize(order.size());
  parallel_for(std::size_t{0}, order.size(), [&](std::size_t i) {
    scene->triangles[i] = traced_triangle(scene->geometry, order[i], assignment.materials[order[i]]);
  });
}

/// The triangle indices of a light list refer to the geometry.
void gather_lights(const PathSceneInput& input, PathScene* scene) {
  const LightList list = build_light_list(input.scene, scene->geometry, input.variant);
  if (list.lights.empty()) return;
  scene->lights = build_light_grid(list);
  std::vector<std::uint32_t> traced(scene->geometry.indices.size() / 3, kNoTriangle);
  for (std::size_t i = 0; i < scene->triangles.size(); ++i)
    traced[scene->triangles[i].source] = static_cast<std::uint32_t>(i);
  scene->triangle_light.assign(scene->triangles.size(), kNoTriangle);
  for (const int i : scene->lights.order) {
    const std::uint32_t source = list.triangles[static_cast<std::size_t>(i)];
    const std::uint32_t triangle = source == kNoTriangle ? kNoTriangle : traced[source];
    if (triangle != kNoTriangle)
      scene->triangle_light[triangle] = static_cast<std::uint32_t>(scene->light_triangles.size());
    scene->light_triangles.push_back(triangle);
  }
}

/// Cells with a density above this (1/sr; the mean over the sphere is 0.08) are sampled by their bilinear radiance:
/// lamps, and the neighbours that they blend into. Elsewhere a cell's mean is enough, and shadow rays need not read its
/// texels.
constexpr float kBright = 0.5f;

TexelCell cell_of(const TracedEnvironment& e, std::size_t texel) {
  const int width = e.tables.width, height = e.tables.height;
  const int x = static_cast<int>(texel) % width, y = static_cast<int>(texel) / width;
  return TexelCell([&](int dx, int dy) {
    const int at = std::clamp(y + dy, 0, height - 1) * width + (x + dx + width) % width;
    const glm::vec4& t = e.texels[static_cast<std::size_t>(at)];
    return static_cast<double>(t.x + t.y + t.z) / 3.0;
  });
}

}  // namespace

TracedEnvironment trace_environment(std::shared_ptr<const Environment> source, EnvironmentTables tables) {
  TracedEnvironment e;
  e.tables = std::move(tables);
  e.black = !(e.tables.luminance_integral > 0.0);
  e.texels.resize(source->rgb.size());
  e.bright.resize(e.texels.size());
  for (std::size_t i = 0; i < e.texels.size(); ++i) {
    e.texels[i] = glm::vec4(source->rgb[i], e.tables.density[i]);
    e.bright[i] = e.tables.density[i] > kBright;
  }
  e.partition = std::make_unique<const EnvironmentPartition>(e.tables);
  e.source = std::move(source);
  return e;
}

EnvironmentLookup TracedEnvironment::look_up(const glm::vec3& direction) const {
  struct Map {
    const glm::vec4* texels;
    int width;
    glm::vec3 fetch_latlong(int x, int y) const { return glm::vec3(texels[y * width + x]); }
    using vec2 = glm::vec2;
    using vec3 = glm::vec3;
    using ivec2 = glm::ivec2;
    static float floor(float v) { return std::floor(v); }
    static int clamp(int v, int low, int high) { return std::clamp(v, low, high); }
#include "shared/latlong_bilinear.glsl"
  };
  const glm::vec2 uv = shared::latlong_uv_from_direction(direction);
  const int width = source->width, height = source->height;
  const int x = std::clamp(static_cast<int>(uv.x * static_cast<float>(width)), 0, width - 1);
  const int y = std::clamp(static_cast<int>(uv.y * static_cast<float>(height)), 0, height - 1);
  return {Map{texels.data(), width}.latlong_bilinear(uv, glm::ivec2(width, height)), x, y};
}

float TracedEnvironment::density_at(std::size_t texel, const glm::vec3& direction) const {
  const float mean = texels[texel].w;
  if (!bright[texel]) return mean;
  const auto width = static_cast<std::size_t>(tables.width);
  const std::size_t row = texel / width;
  const double column = static_cast<double>(shared::latlong_uv_from_direction(direction).x) * tables.width;
  const glm::dvec2 place(column - static_cast<double>(texel - row * width),
                         (partition->sine_above(row) - static_cast<double>(direction.y)) /
                             (partition->sine_above(row) - partition->sine_above(row + 1)));
  const TexelCell cell = cell_of(*this, texel);
  const double cell_mean = cell.mean();
  return cell_mean > 0.0 ? mean * static_cast<float>(cell.at(glm::clamp(place, 0.0, 1.0)) / cell_mean) : mean;
}

EnvironmentPoint TracedEnvironment::follow_light(const EnvironmentPoint& point) const {
  const double column = std::floor(point.x);
  const std::size_t texel = point.row * static_cast<std::size_t>(tables.width) + static_cast<std::size_t>(column);
  if (!bright[texel]) return point;
  const glm::dvec2 place = cell_of(*this, texel).warp({point.x - column, point.t});
  return {point.row, column + std::min(place.x, 1.0 - 1e-9), place.y};
}

std::shared_ptr<const PathScene> build_path_scene(const PathSceneInput& input) {
  auto scene = std::make_shared<PathScene>();
  MeasuredLibrary own;
  MeasuredLibrary* library = input.library ? input.library : &own;
  const auto surfaces = [&] {
    scene->geometry = input.geometry ? *input.geometry : flatten(input.scene);
    scene->atlas = build_texture_atlas(input.scene);
    load_measured(input.scene.materials, library);
    for (std::size_t i = 0; i < input.scene.materials.size(); ++i)
      scene->materials.push_back(make_material(input.scene.materials[i], scene->atlas, i, *library));
    scene->materials.push_back(make_material(Material(), scene->atlas, input.scene.materials.size(), *library));
    gather_triangles(input, scene.get());
    measure_uvs(scene.get());
    parallel_invoke([&] { gather_lights(input, scene.get()); }, [&] { build_hierarchy(scene.get()); });
  };
  parallel_invoke(surfaces, [&] {
    scene->environment = trace_environment(input.environment, load_environment_tables(*input.environment));
  });
  return scene;
}

float alpha_at(const PathScene& scene, std::uint32_t triangle, const glm::vec2& b) {
  const TracedMaterial& m = scene.material_of(triangle);
  float alpha = m.values.base_color.a;
  const std::uint32_t* c = scene.corners(triangle);
  const auto mix = [&](const auto& values) {
    return values[c[0]] * (1.0f - b.x - b.y) + values[c[1]] * b.x + values[c[2]] * b.y;
  };
  if (m.colored) alpha *= mix(scene.geometry.colors).w;
  if (const int texture = m.texture(TextureRole::base_color); texture >= 0) {
    shared::TextureFilter filter{scene.atlas};
    const glm::vec2 uv = filter.texture_coordinates(texture, mix(scene.geometry.uv0), mix(scene.geometry.uv1));
    alpha *= filter.sample_texture(texture, uv, glm::vec2(0.0f), glm::vec2(0.0f)).w;
  }
  return alpha;
}

}  // namespace maquette
