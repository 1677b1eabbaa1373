#pragma once

#include <array>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "render/geometry.h"
#include "scenes/scene.h"

namespace maquette {

struct PatchFit;

/// One item of the scene that shows the scene: a pane, or an opaque mirror.
struct Reflector {
  std::size_t item = 0;  ///< in FlatGeometry::items
  int node = -1;
  std::string name;
  bool mirror = false;  ///< opaque: nothing is seen through it
  bool patch = false;
  std::optional<glm::vec4> plane = {};            ///< of one that is flat, world: dot(n, p) + w = 0, n unit
  std::array<glm::dvec3, 16> points{};            ///< of a patch: world, [row v][column u]
  std::shared_ptr<const PatchFit> fit = nullptr;  ///< of a curved mesh, where the technique projects into patches
  int first_patch = -1;                           ///< of its patches, in the reflectors' block; -1: it has none
};

/// At most this many are drawn; shaders/reflections/reflectors.glsl has the same number.
constexpr std::size_t kMaxReflectors = 16;
/// And at most so many patches of them all; in the same file.
constexpr std::size_t kMaxPatches = 128;
/// Named opaque surfaces mirror up to this roughness; shaders/reflections/glossy.glsl has the same number.
constexpr float kMostGlossyRoughness = 0.5f;

/// The reflectors of the scene: patches and nodes marked so; all panes of a scene that marks none; or, when `names` is
/// not empty, the nodes named so.
/// `materials[i]` is the material of item i. `glossy[i]`: it may be named although it is neither, as the technique
/// draws it where it stands (shaders/reflections/glossy.glsl); empty: none may. Throws Error for a name that is not in
/// the scene, for a node that is nothing of all this, and for too many of them.
std::vector<Reflector> find_reflectors(const Scene& scene, const FlatGeometry& geometry,
                                       const std::vector<const Material*>& materials,
                                       const std::vector<std::string>& names, const std::vector<bool>& glossy = {});

/// Whether anything of the scene that is shown is marked as a reflector.
bool marks_reflectors(const Scene& scene);
/// Whether a surface reflects when none is named: `marks` is marks_reflectors, `glass` that its material is a pane.
bool reflects_unnamed(const Scene& scene, const Node& node, bool marks, bool glass);

/// True for a material that mirrors as a pane, or as a metal smoother than roughness 0.1.
bool can_mirror(const Material& material);

}  // namespace maquette
