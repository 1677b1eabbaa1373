#pragma once

#include <cstddef>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "render/frame/frame_constants.h"
#include "render/frame/pass_timer.h"
#include "render/gl/program_cache.h"
#include "render/octree/octree_buffers.h"
#include "render/reflections/reflectors.h"
#include "render/reflections/targets.h"
#include "render/scene_state/scene_buffers.h"
#include "render/technique/settings.h"

namespace maquette {

class CellBrdfBuffers;
struct PathScene;

/// How far from the ray that a pane's front mirrors the one that its back mirrors may be, for every pixel of the pane:
/// what the second ray meets lies within that of what the first would.
struct GhostDeviation {
  float offset_m = 0.0f;  ///< at its origin
  float turn = 0.0f;      ///< m more for each m along it
  float at(float distance_m) const { return offset_m + turn * distance_m; }
};

/// What the pixels saw of a patch that is fitted to a mesh. Their rays are the mesh's own: the patch finds what they
/// meet.
struct FitDeviation {
  GhostDeviation reach;               ///< of the rays from the patch's; 0 where it is not seen
  glm::vec2 most{0.0f}, least{0.0f};  ///< 4 plus the largest of the parameters seen; 4 minus the least
};

/// What a technique finds hits for, in one frame. The frame block on binding 0 has the size of the targets.
struct ReflectionFrame {
  const FrameConstants* constants = nullptr;
  const SceneBuffers* buffers = nullptr;
  const std::vector<Reflector>* reflectors = nullptr;
  const std::vector<bool>* occluding = nullptr;        ///< by item: drawn and opaque, so that mirrored rays end there
  std::uint32_t geometry_epoch = 0;                    ///< revision of the geometry
  const PathScene* cut_out = nullptr;                  ///< of this geometry, where textures or vertices cut out parts
  const OctreeBuffers* octree = nullptr;               ///< bound; null unless the plan has one
  const CellBrdfBuffers* cells = nullptr;              ///< of its cells; null unless the plan has them
  const std::vector<GhostDeviation>* ghost = nullptr;  ///< by reflector; null where the rays are those of the front
  const std::vector<FitDeviation>* fits = nullptr;     ///< by patch; null where none is fitted
  const Settings* settings = nullptr;
  ReflectionTargets* targets = nullptr;
  ProgramCache* programs = nullptr;
  PassTimer* timer = nullptr;
  std::function<void(const Program&)> for_each_ray;  ///< runs it over `targets->tiles` (shaders/shared/tiles.glsl)
};

/// How the hits of the mirrored rays are found. The panes' rays are made before, resolving, shading and compositing are
/// done after it, the same for all.
class ReflectorTechnique {
 public:
  virtual ~ReflectorTechnique() = default;
  /// Writes `targets->triangle` for every pixel; a technique whose hits are no triangles writes `surface` and `depth`
  /// too, and says so by resolves(): the triangle is then one near by, for what is baked per vertex.
  /// Ends its planned passes on `frame.timer`. Where resolves() is false, its plan ends with add_resolve_pass().
  virtual void trace(const ReflectionFrame& frame) = 0;
  virtual bool resolves() const { return false; }
  /// Whether it writes `targets->low_confidence`: its confidence is low at some pixels.
  virtual bool marks_low_confidence() const { return false; }
  /// Shades what lies before the hits and lets a share of them through; true when there is such, for the composition
  /// (unit 48, storage 13). `traced`: shadow rays through the octree; `samples` of the environment for each.
  virtual bool shade_layers(const ReflectionFrame&, bool /*traced*/, int /*samples*/) { return false; }
  /// Bytes of its own buffers by vocabulary word.
  virtual void add_bytes(std::map<std::string, std::size_t>*) const {}
  /// Counters of the frame just traced.
  virtual void add_counters(std::map<std::string, double>*) const {}
};

}  // namespace maquette
