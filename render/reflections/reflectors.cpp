#include "render/reflections/reflectors.h"

#include <algorithm>

#include "scenes/error.h"
#include "scenes/suggest.h"

namespace maquette {

namespace {

bool is_marked(const Scene& scene, const Node& node) {
  if (node.patch >= 0) return node.reflector || scene.patches[static_cast<std::size_t>(node.patch)].reflector;
  return node.reflector;
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
  if (!out.patch) return out;
  const glm::dmat4 transform(world[static_cast<std::size_t>(drawn.node)]);
  const BezierPatch& patch = scene.patches[static_cast<std::size_t>(drawn.patch)];
  for (std::size_t k = 0; k < 16; ++k)
    out.points[k] = glm::dvec3(transform * glm::dvec4(glm::dvec3(patch.points[k]), 1.0));
  return out;
}

void check_names(const Scene& scene, const std::vector<std::string>& names) {
  std::vector<std::string> known;
  for (const Node& node : scene.nodes)
    if (node.mesh >= 0 || node.patch >= 0) known.push_back(node.name);
  for (const std::string& name : names)
    if (std::find(known.begin(), known.end(), name) == known.end())
      throw Error("--reflector " + name, "the scene has no node of that name with a surface",
                  did_you_mean(name, known));
}

}  // namespace

bool can_mirror(const Material& material) {
  if (material.glass) return true;
  return material.measured.empty() && material.metallic > 0.5f && material.roughness < 0.1f;
}

std::vector<Reflector> find_reflectors(const Scene& scene, const FlatGeometry& geometry,
                                       const std::vector<const Material*>& materials,
                                       const std::vector<std::string>& names) {
  check_names(scene, names);
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  std::vector<Reflector> found;
  for (std::size_t i = 0; i < geometry.items.size(); ++i) {
    if (geometry.items[i].node < 0) continue;
    const Node& node = scene.nodes[static_cast<std::size_t>(geometry.items[i].node)];
    const bool named = std::find(names.begin(), names.end(), node.name) != names.end();
    if (names.empty() ? !is_marked(scene, node) : !named) continue;
    if (!can_mirror(*materials[i])) {
      if (names.empty()) continue;
      throw Error("--reflector " + node.name,
                  "its material '" + materials[i]->name + "' is neither glass nor a smooth metal",
                  "name a pane or a mirror, or give it --material " + materials[i]->name + "=builtin:glass");
    }
    found.push_back(make_reflector(scene, geometry, i, !materials[i]->glass, world));
  }
  if (found.size() > kMaxReflectors)
    throw Error("--reflections",
                std::to_string(found.size()) + " reflectors are more than the " + std::to_string(kMaxReflectors) +
                    " that are drawn at once",
                "name those that matter with --reflector");
  return found;
}

}  // namespace maquette
