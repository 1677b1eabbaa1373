#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace maquette {

/// Three directions and their shares, which sum to 1. Fewer than three: the others have the share 0 and a valid index.
struct DirectionWeights {
  std::array<int, 3> index{};
  glm::vec3 weight{1.0f, 0.0f, 0.0f};
};

/// Interpolates between measured directions of the upper hemisphere, on their spherical Delaunay triangulation (the
/// convex hull of the directions). Continuous: weights do not jump where a direction leaves a triangle. Beyond the
/// outermost directions (75 degrees in most sets) the nearest point of the triangulation's border counts, by angle.
/// One direction is constant; directions on one great circle are interpolated along it.
class DirectionMesh {
 public:
  DirectionMesh() = default;
  /// Unit directions with z >= 0, no two equal, at least one.
  explicit DirectionMesh(std::vector<glm::dvec3> directions);

  /// `direction`: unit.
  DirectionWeights find(const glm::vec3& direction) const;
  const std::vector<glm::dvec3>& directions() const { return directions_; }
  std::size_t size() const { return directions_.size(); }
  const std::vector<std::array<int, 3>>& triangles() const { return triangles_; }
  const std::vector<std::array<int, 2>>& border() const { return border_; }

  /// Integrals over the upper hemisphere of what each direction contributes to the interpolation: sums of
  /// `solid_angle` times values are integrals of the interpolated function, and with `projected` those with the cosine.
  /// They sum to 2 pi and pi.
  struct Quadrature {
    std::vector<double> solid_angle, projected;
  };
  Quadrature quadrature() const;

 private:
  void triangulate();
  void build_grid();
  void order_great_circle();
  /// The triangle that contains `direction`, from `start` on; -1 beyond the border.
  int walk(int start, const glm::vec3& direction, glm::vec3* weights) const;
  DirectionWeights nearest_on_border(const glm::vec3& direction) const;

  std::vector<glm::dvec3> directions_;
  std::vector<std::array<int, 3>> triangles_, neighbours_;  ///< neighbour k lies opposite of corner k; -1: none
  std::vector<glm::mat3> inverses_;                         ///< per triangle: barycentric weights of a direction
  std::vector<std::array<int, 2>> border_;
  std::vector<std::int32_t> grid_;  ///< where to start walking, by x and y
};

/// Direction of angles in degrees: x = sin theta cos phi, y = sin theta sin phi, z = cos theta.
glm::dvec3 direction_of_angles(double theta_deg, double phi_deg);

/// The 81 directions of the UBO sets: rings at 0, 15, ... 75 degrees of 1, 6, 12, 18, 20 and 24.
std::vector<glm::dvec3> ubo_directions();

}  // namespace maquette
