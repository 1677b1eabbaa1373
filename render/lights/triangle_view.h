#pragma once

#include <glm/glm.hpp>

#include "render/lights/light_list.h"

namespace maquette {

/// An emissive triangle as seen from a point: samples directions uniformly over its solid angle, so that no sample
/// weighs more than a hemisphere full of its light, however near it is. Samples by area (light_sample) have no such
/// bound. In double: seen from 1e-5 of its size, the corners lie on the horizon, and float cannot hold the differences
/// of their directions. Source: Arvo 1995, "Stratified Sampling of Spherical Triangles"; without its angles: Peters
/// 2021, "BRDF Importance Sampling for Polygonal Lights", Sec. 3.2.
class TriangleView {
 public:
  /// `light`: of kind kLightTriangle. `point`: m.
  TriangleView(const LightRecord& light, const glm::vec3& point);

  /// sr; 0 for points behind the triangle and in its plane, within the rounding error of its own points.
  double solid_angle() const { return 2.0 * half_sr_; }

  struct Sample {
    glm::vec3 wi{};    ///< unit, towards the triangle
    float distance_m;  ///< to the triangle
    glm::vec2 uv{};    ///< coordinates along its edges there
  };
  /// Uniform over the solid angle, which must not be 0; `u` in [0, 1)^2.
  Sample sample(const glm::vec2& u) const;

 private:
  glm::dvec3 a_{0.0}, b_{0.0}, c_{0.0};  ///< unit, to the corners
  glm::dvec3 distances_m_{1.0};
  double volume_ = 0.0;  ///< |a . (b x c)|
  double half_sr_ = 0.0;
};

}  // namespace maquette
