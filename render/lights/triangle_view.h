#pragma once

#include <glm/glm.hpp>

#include "render/lights/light_list.h"

namespace maquette {

/// An emissive triangle as a point sees it: what draws directions towards it evenly over its solid angle, so that no
/// sample brings more than a hemisphere full of its light however near it is; samples by area (light_sample) have no
/// such bound. In double: seen from a hundred-thousandth of its size the corners lie on
/// the horizon, and what is between them is a difference of their directions that floats do not hold.
/// Source: Arvo 1995, "Stratified Sampling of Spherical Triangles"; without its angles: Peters 2021, "BRDF Importance
/// Sampling for Polygonal Lights", Sec. 3.2.
class TriangleView {
 public:
  /// `light`: of kind kLightTriangle. `point`: m.
  TriangleView(const LightRecord& light, const glm::vec3& point);

  /// sr; 0 where the triangle shines away from the point, and in its plane, as far as the rounding of its
  /// own points tells.
  double solid_angle() const { return 2.0 * half_sr_; }

  struct Sample {
    glm::vec3 wi;      ///< unit, towards the triangle
    float distance_m;  ///< to where it meets it
    glm::vec2 uv;      ///< the shares of its edges there
  };
  /// Even over the solid angle, which is not 0, for `u` in [0, 1)^2.
  Sample sample(const glm::vec2& u) const;

 private:
  glm::dvec3 a_{0.0}, b_{0.0}, c_{0.0};  ///< unit, to the corners
  glm::dvec3 distances_m_{1.0};
  double volume_ = 0.0;  ///< |a . (b x c)|
  double half_sr_ = 0.0;
};

}  // namespace maquette
