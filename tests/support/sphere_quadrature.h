#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "scenes/brdf.h"
#include "scenes/environment.h"
#include "scenes/image.h"

namespace maquette::test {

/// Square picture of the unit sphere at the origin, eye on the +Z axis.
struct SphereView {
  double distance = 4.5;  ///< of the eye, m
  double fov_y_rad = 0.5;
  int side = 32;  ///< pixels
};

struct SpherePixel {
  int x = 0, y = 0;
  glm::dvec3 radiance{0.0};
};
struct SphereQuadrature {
  std::vector<SpherePixel> pixels;  ///< pixels whose centre ray hits the sphere
  double estimated_error = 0.0;     ///< root mean square of the quadrature's own relative estimates
};

/// Direct light at the pixel centres by evaluate_direct, on all cores: 10 to 40 ms of one core a pixel. With `normals`
/// (a debug view of the same size), these are used in place of the sphere's own, where both exist.
SphereQuadrature integrate_sphere(const Environment& environment, const BrdfTable& brdf, const SphereView& view,
                                  const Image* normals = nullptr);

/// Relative RMSE over R, G, B of the pixels that the picture covers, relative to the mean luminance of the quadrature.
double relative_rmse(const Image& picture, const SphereQuadrature& quadrature);

/// Luminance of the brightest texel over the mean over the sphere.
double peak_over_mean(const Environment& environment);

}  // namespace maquette::test
