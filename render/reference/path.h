#pragma once

#include <functional>
#include <span>
#include <vector>

#include "render/reference/light_sampling.h"
#include "render/reference/mirror_guide.h"
#include "render/reference/path_sampler.h"
#include "render/reference/surface.h"

namespace maquette {

/// One path's estimate of the radiance along a ray.
struct PathEstimate {
  glm::vec3 radiance{0.0f};  ///< cd/m2
  bool covered = false;      ///< hits a surface other than panes
  std::uint32_t rays = 0;
};

class FullPath;

/// Which share of what shines on the straight line of a ray counts: of an emissive triangle, or, for kNoTriangle, of
/// the sky, which plain importance sampling draws with the density `sky_density` (1/sr). For estimators that find the
/// rest by light sampling.
using SeenShare = std::function<float(std::uint32_t triangle, float sky_density)>;

/// A camera ray and the surfaces that it reaches through and by panes. It is the same for all paths through a pixel's
/// centre. `differential`: of a camera ray, which culls back faces of single-sided surfaces; null for any other ray.
/// `chance`: random number that decides about blended surfaces, for rays that are not camera rays. `share`: may be
/// null.
class CameraRay {
 public:
  CameraRay(const PathScene& scene, const EnvironmentLight& environment, const Ray& ray,
            const RayDifferential* differential, std::uint32_t chance, const SeenShare* share = nullptr);
  std::uint32_t rays() const { return rays_; }  ///< traced by the constructor

 private:
  friend class PathGroup;
  friend class FullPath;
  class Splitter;
  struct Surface {
    SurfacePoint point;
    glm::vec3 weight{};
    bool straight;
  };
  const PathScene& scene_;
  const EnvironmentLight& environment_;
  glm::vec3 radiance_{0.0f};  ///< of the sky and the lamps that are seen directly
  bool covered_ = false;
  std::uint32_t rays_ = 0;
  std::vector<Surface> surfaces_;
};

/// A path that continues from a camera ray.
struct PathTask {
  const CameraRay* ray = nullptr;
  PathSampler sampler;
  std::uint32_t tile = 0;  ///< adjacent paths with the same number share light (path_sharing.h); 0: shares with none
  PathEstimate estimate;
};

/// Traces paths with full transport, several at a time: each path prefetches what it reads next, and the others run
/// meanwhile. A path's result depends on its tile, not on which other paths are traced with it. Not thread-safe.
class PathGroup {
 public:
  static constexpr std::size_t kMost = 8;
  /// `mirrors`: may be null.
  PathGroup(const PathScene& scene, const EnvironmentLight& environment, int max_bounces,
            const MirrorGuide* mirrors = nullptr);
  ~PathGroup();
  PathGroup(const PathGroup&) = delete;
  PathGroup& operator=(const PathGroup&) = delete;
  /// Fills the estimates of at most kMost tasks; all tasks of a tile have to come in one call.
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
