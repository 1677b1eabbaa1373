#include "render/reflections/reflectors.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <set>

#include "scenes/error.h"
#include "scenes/node_paths.h"
#include "scenes/suggest.h"

namespace maquette {

namespace {

bool is_marked(const Scene& scene, const Node& node) {
  if (node.patch >= 0) return node.reflector || scene.patches[static_cast<std::size_t>(node.patch)].reflector;
  return node.mesh >= 0 && node.reflector;
}

/// The plane that contains all points within 1e-6 of their extent; normals, if any, must agree with it.
std::optional<glm::vec4> find_plane(const std::vector<glm::vec3>& points, const std::vector<glm::vec3>& normals) {
  constexpr double kFlat = 1e-6, kSameNormal = 1e-3;
  if (points.size() < 3) return std::nullopt;
  const glm::dvec3 origin(points[0]);
  glm::dvec3 far_point = origin, normal(0.0);
  for (const glm::vec3& p : points)
    if (glm::length(glm::dvec3(p) - origin) > glm::length(far_point - origin)) far_point = p;
  const double extent = glm::length(far_point - origin);
  for (const glm::vec3& p : points) {
    const glm::dvec3 n = glm::cross(far_point - origin, glm::dvec3(p) - origin);
    if (glm::length(n) > glm::length(normal)) normal = n;
  }
  if (!(glm::length(normal) > kFlat * extent * extent)) return std::nullopt;
  normal = glm::normalize(normal);
  for (const glm::vec3& p : points)
    if (std::abs(glm::dot(normal, glm::dvec3(p) - origin)) > kFlat * extent) return std::nullopt;
  for (const glm::vec3& n : normals)
    if (std::abs(glm::dot(normal, glm::dvec3(n))) < 1.0 - 0.5 * kSameNormal * kSameNormal) return std::nullopt;
  return glm::vec4(glm::vec3(normal), static_cast<float>(-glm::dot(normal, origin)));
}

Reflector make_reflector(const Scene& scene, const FlatGeometry& geometry, std::size_t item, bool mirror,
                         const std::vector<glm::mat4>& world) {
  const DrawItem& drawn = geometry.items[item];
  Reflector out;
  out.item = item;
  out.node = drawn.node;
  out.name = scene.nodes[static_cast<std::size_t>(drawn.node)].name;
  out.mirror = mirror;
  out.patch = drawn.patch >= 0;
  if (!out.patch) {
    const auto first = static_cast<std::ptrdiff_t>(drawn.first_vertex),
               count = static_cast<std::ptrdiff_t>(drawn.vertex_count);
    out.plane = find_plane({geometry.positions.begin() + first, geometry.positions.begin() + first + count},
                           {geometry.normals.begin() + first, geometry.normals.begin() + first + count});
    return out;
  }
  const glm::dmat4 transform(world[static_cast<std::size_t>(drawn.node)]);
  const BezierPatch& patch = scene.patches[static_cast<std::size_t>(drawn.patch)];
  for (std::size_t k = 0; k < 16; ++k)
    out.points[k] = glm::dvec3(transform * glm::dvec4(glm::dvec3(patch.points[k]), 1.0));
  out.plane = find_plane({out.points.begin(), out.points.end()}, {});
  return out;
}

/// [node] what named it, in `names`: its name, or its path.
std::map<int, std::string> named_nodes(const Scene& scene, const std::vector<std::string>& names) {
  std::map<int, std::string> named;
  if (names.empty()) return named;
  const std::vector<std::string> paths = node_paths(scene);
  std::vector<std::string> known;
  for (const Node& node : scene.nodes)
    if (node.mesh >= 0 || node.patch >= 0) known.push_back(node.name);
  for (const std::string& name : names) {
    bool any = false;
    for (const int i : called_nodes(scene, paths, name)) {
      const Node& node = scene.nodes[static_cast<std::size_t>(i)];
      if (node.mesh < 0 && node.patch < 0) continue;
      named.emplace(i, name);
      any = true;
    }
    if (!any)
      throw Error("--reflector " + name, "the scene has no node of that name with a surface",
                  did_you_mean(name, known));
  }
  return named;
}

}  // namespace

bool marks_reflectors(const Scene& scene) {
  return std::any_of(scene.nodes.begin(), scene.nodes.end(),
                     [&](const Node& node) { return node.visible && is_marked(scene, node); });
}

bool reflects_unnamed(const Scene& scene, const Node& node, bool marks, bool glass) {
  return marks ? is_marked(scene, node) : glass;
}

bool can_mirror(const Material& material) {
  if (material.glass) return true;
  return material.measured.empty() && material.metallic > 0.5f && material.roughness < 0.1f;
}

std::vector<Reflector> find_reflectors(const Scene& scene, const FlatGeometry& geometry,
                                       const std::vector<const Material*>& materials,
                                       const std::vector<std::string>& names, const std::vector<bool>& glossy) {
  const std::map<int, std::string> calls = named_nodes(scene, names);
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  const bool marks = marks_reflectors(scene);
  std::vector<Reflector> found;
  std::map<std::string, const Material*> dull;  // materials under a name of which nothing mirrors so far
  std::set<std::string> mirrored;
  for (std::size_t i = 0; i < geometry.items.size(); ++i) {
    if (geometry.items[i].node < 0) continue;
    const Node& node = scene.nodes[static_cast<std::size_t>(geometry.items[i].node)];
    const auto call = calls.find(geometry.items[i].node);
    const bool named = call != calls.end();
    if (names.empty() ? !reflects_unnamed(scene, node, marks, materials[i]->glass) : !named) continue;
    if (!can_mirror(*materials[i])) {
      if (named && !glossy.empty() && glossy[i])
        mirrored.insert(call->second);
      else if (named)
        dull.emplace(call->second, materials[i]);
      continue;
    }
    if (named) mirrored.insert(call->second);
    found.push_back(make_reflector(scene, geometry, i, !materials[i]->glass, world));
  }
  // The frame of a pane need not mirror, but some surface under the name must.
  for (const auto& [name, material] : dull)
    if (!mirrored.contains(name))
      throw Error("--reflector " + name,
                  "its material '" + material->name + "' is neither glass nor a smooth metal" +
                      (glossy.empty() ? "" : " nor glossy"),
                  "name a pane or a mirror (with a technique that follows single rays, anything glossy), or give it "
                  "--material " +
                      material->name + "=builtin:glass");
  if (found.size() > kMaxReflectors)
    throw Error("--reflections",
                std::to_string(found.size()) + " reflectors are more than the " + std::to_string(kMaxReflectors) +
                    " that are drawn at once",
                "name those that matter with --reflector");
  return found;
}

}  // namespace maquette
