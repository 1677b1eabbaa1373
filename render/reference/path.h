#pragma once

#include <span>
#include <vector>

#include "render/reference/light_sampling.h"
#include "render/reference/mirror_guide.h"
#include "render/reference/path_sampler.h"
#include "render/reference/surface.h"

namespace maquette {

/// What one path says of a ray.
struct PathEstimate {
  glm::vec3 radiance{0.0f};  ///< cd/m2
  bool covered = false;      ///< something other than sky and panes
  std::uint32_t rays = 0;    ///< that were traced
};

class FullPath;

/// A ray and all that panes make of it, up to the surfaces that scatter: the same for every path of a pixel centre.
/// `differential`: of a camera ray, which culls backs of single-sided surfaces; null for any other. `chance`: decides
/// about blended surfaces for rays that are none of the camera's.
class CameraRay {
 public:
  CameraRay(const PathScene& scene, const EnvironmentLight& environment, const Ray& ray,
            const RayDifferential* differential, std::uint32_t chance);
  std::uint32_t rays() const { return rays_; }  ///< traced by the constructor

 private:
  friend class PathGroup;
  friend class FullPath;
  class Splitter;
  struct Surface {
    SurfacePoint point;
    glm::vec3 weight;
    bool straight;
  };
  const PathScene& scene_;
  const EnvironmentLight& environment_;
  glm::vec3 radiance_{0.0f};  ///< of sky and lamps that are seen
  bool covered_ = false;
  std::uint32_t rays_ = 0;
  std::vector<Surface> surfaces_;
};

/// A path on from a camera ray.
struct PathTask {
  const CameraRay* ray = nullptr;
  PathSampler sampler;
  std::uint32_t tile = 0;  ///< paths of one tile, beside each other, share light (path_sharing.h); 0: alone
  PathEstimate estimate;
};

/// Follows paths, full transport, several in turn: what one reads next comes from memory while the others are at work.
/// What they are depends on their tile, not on what else is under way. Not for several threads at once.
class PathGroup {
 public:
  static constexpr std::size_t kMost = 8;
  /// `mirrors`: may be null.
  PathGroup(const PathScene& scene, const EnvironmentLight& environment, int max_bounces,
            const MirrorGuide* mirrors = nullptr);
  ~PathGroup();
  PathGroup(const PathGroup&) = delete;
  PathGroup& operator=(const PathGroup&) = delete;
  /// Fills the estimates of kMost tasks at most, a tile's all at once.
  void follow(std::span<PathTask> tasks);

 private:
  void share(std::span<PathTask> tasks) const;

  const PathScene& scene_;
  const MirrorGuide* mirrors_;
  std::vector<FullPath> paths_;
};

PathEstimate estimate_direct(const PathScene& scene, const EnvironmentLight& environment, const PathSampler& sampler,
                             const Ray& ray, const RayDifferential* differential);

}  // namespace maquette
