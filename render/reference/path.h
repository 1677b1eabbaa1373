#pragma once

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

/// A ray and all that panes make of it, up to the surfaces that scatter: the same for every path of a pixel centre.
/// `differential`: of a camera ray, which culls backs of single-sided surfaces; null for any other. `chance`: decides
/// about blended surfaces for rays that are none of the camera's.
class CameraRay {
 public:
  CameraRay(const PathScene& scene, const EnvironmentLight& environment, const Ray& ray,
            const RayDifferential* differential, std::uint32_t chance);
  /// One path on from there, full transport. `mirrors`: may be null.
  PathEstimate estimate(const PathSampler& sampler, int max_bounces, const MirrorGuide* mirrors = nullptr) const;
  std::uint32_t rays() const { return rays_; }  ///< traced by the constructor

 private:
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

PathEstimate estimate_direct(const PathScene& scene, const EnvironmentLight& environment, const PathSampler& sampler,
                             const Ray& ray, const RayDifferential* differential);

}  // namespace maquette
