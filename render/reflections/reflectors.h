#pragma once

#include <array>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/scene_state/geometry.h"
#include "scenes/scene.h"

namespace maquette {

struct PatchFit;

/// One item that shows reflections of the scene: a pane, or an opaque mirror.
struct Reflector {
  std::size_t item = 0;  ///< in FlatGeometry::items
  int node = -1;
  std::string name;
  bool mirror = false;  ///< opaque: no transmission
  bool patch = false;
  std::optional<glm::vec4> plane = {};            ///< plane of a flat reflector, world: dot(n, p) + w = 0, n unit
  std::array<glm::dvec3, 16> points{};            ///< control points of a patch: world, [row v][column u]
  std::shared_ptr<const PatchFit> fit = nullptr;  ///< of a curved mesh, when the technique projects into patches
  int first_patch = -1;                           ///< index of its first patch in the reflectors' block; -1: none
};

/// Largest number of reflectors; the same in shaders/reflections/reflectors.glsl.
constexpr std::size_t kMaxReflectors = 16;
/// Largest number of patches of all reflectors; the same in that file.
constexpr std::size_t kMaxPatches = 128;
/// Largest roughness of a named opaque mirror; the same in shaders/reflections/glossy.glsl.
constexpr float kMaxGlossyRoughness = 0.5f;

/// The reflectors of the scene: the patches and nodes marked as such; or all panes of a scene without marks; or, when
/// `names` is not empty, the nodes of these names.
/// `materials[i]` is the material of item i. `glossy[i]`: the item may be named although it is neither pane nor mirror,
/// because the technique draws glossy surfaces (shaders/reflections/glossy.glsl); empty: none may. Throws Error for a
/// name that is not in the scene, for a node that cannot reflect, and for too many reflectors.
std::vector<Reflector> find_reflectors(const Scene& scene, const FlatGeometry& geometry,
                                       const std::vector<const Material*>& materials,
                                       const std::vector<std::string>& names, const std::vector<bool>& glossy = {});

/// Whether any visible part of the scene is marked as a reflector.
bool marks_reflectors(const Scene& scene);
/// Whether a surface reflects when no reflector is named. `marks`: result of marks_reflectors; `glass`: its material is
/// a pane.
bool reflects_unnamed(const Scene& scene, const Node& node, bool marks, bool glass);

/// True for panes, and for metals smoother than roughness 0.1.
bool can_mirror(const Material& material);

}  // namespace maquette
