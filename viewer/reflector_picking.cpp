#include "viewer/reflector_picking.h"

#include <algorithm>
#include <cmath>

#include "render/math/shared_formulas.h"
#include "render/reflections/reflectors.h"
#include "render/scene_state/material_overrides.h"
#include "scenes/node_paths.h"
#include "scenes/subdivision.h"

namespace maquette {

namespace {

constexpr int kPatchSide = 24;  // quads; precise enough for a click

/// Materials by index, with the replacements of the edits.
class EditedMaterials {
 public:
  EditedMaterials(const Scene& scene, const Edits& edits) : materials_(effective_materials(scene, edits.materials)) {}
  const Material& operator[](int index) const {
    return index < 0 || index >= static_cast<int>(materials_.size()) ? none_
                                                                     : materials_[static_cast<std::size_t>(index)];
  }

 private:
  std::vector<Material> materials_;
  Material none_;
};

/// Calls `use(primitive, material)` for the surfaces of a node.
template <typename Use>
void each_surface(const Scene& scene, const Node& node, int variant, const Use& use) {
  if (node.mesh >= 0)
    for (const Primitive& primitive : scene.meshes[static_cast<std::size_t>(node.mesh)].primitives)
      use(primitive, material_of(primitive, variant));
  if (node.patch >= 0) {
    const BezierPatch& patch = scene.patches[static_cast<std::size_t>(node.patch)];
    use(tessellate_patch(patch, kPatchSide), patch.material);
  }
}

bool is_shown(const Scene& scene, int index, const std::set<int>& hidden) {
  for (int i = index, steps = 0; i >= 0 && steps <= static_cast<int>(scene.nodes.size()); ++steps) {
    if (hidden.contains(i)) return false;
    i = scene.nodes[static_cast<std::size_t>(i)].parent;
  }
  return scene.nodes[static_cast<std::size_t>(index)].visible;
}

}  // namespace

std::set<int> reflecting_nodes(const Scene& scene, const Edits& edits) {
  const bool marks = marks_reflectors(scene);
  const EditedMaterials materials(scene, edits);
  const std::set<int> named = called_nodes(scene, edits.reflectors);
  const int variant = variant_index(scene, edits.variant);
  std::set<int> nodes;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    const Node& node = scene.nodes[i];
    if (!node.visible || (node.mesh < 0 && node.patch < 0)) continue;
    if (!edits.reflectors.empty() && !named.contains(static_cast<int>(i))) continue;
    const auto reflects = [&](int index) {
      const Material& material = materials[index];
      return can_mirror(material) &&
             (!edits.reflectors.empty() || reflects_unnamed(scene, node, marks, material.glass));
    };
    bool any = node.patch >= 0 && reflects(scene.patches[static_cast<std::size_t>(node.patch)].material);
    if (node.mesh >= 0)
      for (const Primitive& primitive : scene.meshes[static_cast<std::size_t>(node.mesh)].primitives)
        any = any || reflects(material_of(primitive, variant));
    if (any) nodes.insert(static_cast<int>(i));
  }
  return nodes;
}

int find_mirror(const Scene& scene, const Edits& edits, const glm::vec3& origin, const glm::vec3& direction,
                float limit_m) {
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  const EditedMaterials materials(scene, edits);
  const std::set<int> hidden = called_nodes(scene, edits.hidden_nodes);
  const int variant = variant_index(scene, edits.variant);
  int found = -1;
  float nearest = limit_m;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    if (!is_shown(scene, static_cast<int>(i), hidden)) continue;
    // Distances along the ray are the same in the node's frame, because its direction is not normalised there.
    const glm::dmat4 node_from_world = glm::inverse(glm::dmat4(world[i]));
    const glm::vec3 from(node_from_world * glm::dvec4(glm::dvec3(origin), 1.0)),
        to(node_from_world * glm::dvec4(glm::dvec3(direction), 0.0));
    each_surface(scene, scene.nodes[i], variant, [&](const Primitive& primitive, int material) {
      if (!can_mirror(materials[material])) return;
      for (std::size_t k = 0; k + 2 < primitive.indices.size(); k += 3) {
        const auto corner = [&](std::size_t n) { return primitive.positions[primitive.indices[k + n]]; };
        const glm::vec3 first = corner(0);
        const shared::TriangleHit hit =
            shared::intersect_plane_of_triangle(from, to, first, corner(1) - first, corner(2) - first);
        const glm::vec2& b = hit.barycentric;
        const bool inside = b.x >= 0.0f && b.y >= 0.0f && b.x + b.y <= 1.0f;
        if (!inside || !(hit.depth > 0.0f && hit.depth < nearest)) continue;
        nearest = hit.depth;
        found = static_cast<int>(i);
      }
    });
  }
  return found;
}

bool toggle_reflector(const Scene& scene, int node, Edits* edits) {
  const std::vector<std::string> paths = node_paths(scene);
  std::set<std::string> reflectors;
  for (const int k : reflecting_nodes(scene, *edits)) reflectors.insert(paths[static_cast<std::size_t>(k)]);
  const std::string& path = paths[static_cast<std::size_t>(node)];
  if (reflectors.erase(path) == 0) reflectors.insert(path);
  if (reflectors.empty()) return false;
  edits->reflectors = std::move(reflectors);
  return true;
}

}  // namespace maquette
