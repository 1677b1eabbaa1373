#pragma once

#include "render/reference/light_sampling.h"
#include "render/reference/path_sampler.h"
#include "render/reference/surface.h"

namespace maquette {

/// What one path says of a ray.
struct PathEstimate {
  glm::vec3 radiance{0.0f};  ///< cd/m2
  bool covered = false;      ///< something other than sky and panes
  std::uint32_t rays = 0;    ///< that were traced
};

/// `differential`: of a camera ray; null for any other. A camera ray culls backs of single-sided surfaces.
PathEstimate estimate_full(const PathScene& scene, const EnvironmentLight& environment, const PathSampler& sampler,
                           const Ray& ray, const RayDifferential* differential, int max_bounces);
PathEstimate estimate_direct(const PathScene& scene, const EnvironmentLight& environment, const PathSampler& sampler,
                             const Ray& ray, const RayDifferential* differential);

}  // namespace maquette
