#pragma once

#include "render/reference/surface.h"

namespace maquette {

/// BRDF (1/sr) and the density (1/sr) with which sample_scattering gives wi. Both directions local, above the horizon.
struct Scattering {
  glm::vec3 f{0.0f};
  float pdf = 0.0f;
};
Scattering evaluate_scattering(const SurfacePoint& point, const glm::vec3& wi);

struct ScatteringSample {
  glm::vec3 wi{0.0f};
  glm::vec3 f{0.0f};
  float pdf = 0.0f;  ///< 0: worth nothing, but it counts
};
/// `u` picks the direction, `lobe` which lobe of an analytic material; all in [0, 1).
ScatteringSample sample_scattering(const SurfacePoint& point, const glm::vec2& u, float lobe);

/// Trilinear between bin centres, as evaluate_brdf, in float. Directions above the horizon.
glm::vec3 lookup_brdf(const BrdfTable& table, const glm::vec3& wi, const glm::vec3& wo);

}  // namespace maquette
