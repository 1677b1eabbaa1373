#pragma once

#include <Eigen/Core>
#include <glm/glm.hpp>
#include <vector>

#include "scenes/environment.h"

namespace maquette {

/// Directions of a cube of light: six faces (+x, -x, +y, -y, +z, -z) of side x side texels, [face][y][x]. A point of a
/// face has coordinates u, v in [-1, 1] (glm::vec2 of `cube_point`).
class CubeDirections {
 public:
  /// `side`: a power of two.
  explicit CubeDirections(int side);
  int side() const { return side_; }
  Eigen::Index count() const { return static_cast<Eigen::Index>(directions_.size()); }
  /// Unit, of the middle of a texel.
  const glm::dvec3& direction(Eigen::Index i) const { return directions_[static_cast<std::size_t>(i)]; }
  /// sr, exact: they sum to 4 pi. Every sum, norm and decomposition of light and transfer is weighted by these.
  const Eigen::VectorXd& solid_angles() const { return solid_angles_; }
  /// Unit direction of a point of a texel: `at` in [0, 1]^2.
  glm::dvec3 direction_within(Eigen::Index i, const glm::dvec2& at) const;

 private:
  int side_;
  std::vector<glm::dvec3> directions_;
  Eigen::VectorXd solid_angles_;
};

/// Direction of a point of a face, not normalised: one coordinate is 1 or -1.
glm::dvec3 cube_direction(int face, double u, double v);
/// Face and coordinates of a direction.
struct CubePoint {
  int face = 0;
  double u = 0.0, v = 0.0;
};
CubePoint cube_point(const glm::dvec3& direction);

/// Light of an environment on a cube: radiance of each direction, [direction][rgb], stored units.
using CubeLight = Eigen::Matrix<float, Eigen::Dynamic, 3>;

/// An environment on cubes of falling resolution, each texel the mean of its area: made once for an environment, read
/// under any rotation.
class CubePyramid {
 public:
  CubePyramid() = default;
  /// Cost: about 0.2 s for 1024 x 512 texels.
  explicit CubePyramid(const Environment& environment);
  /// The light of each texel of `directions`, prefiltered over its area: the mean over 12 x 12 points of it, in a fixed
  /// order. `environment_from_cube`: rotation.
  CubeLight resample(const CubeDirections& directions, const glm::dmat3& environment_from_cube) const;
  bool empty() const { return levels_.empty(); }
  std::size_t bytes() const;

 private:
  /// Six faces with a border of one texel, which belongs to their neighbours: [face][y][x].
  struct Level {
    int side = 0;
    std::vector<glm::vec3> texels;
    const glm::vec3& at(int face, int x, int y) const {
      return texels[static_cast<std::size_t>(((face * (side + 2)) + y + 1) * (side + 2) + x + 1)];
    }
    glm::vec3& at(int face, int x, int y) {
      return texels[static_cast<std::size_t>(((face * (side + 2)) + y + 1) * (side + 2) + x + 1)];
    }
    glm::vec3 bilinear(const glm::vec3& direction) const;
  };
  static Level make_finest(const Environment& environment, int side);
  static Level halved(const Level& fine);
  static void fill_borders(Level* level);

  std::vector<Level> levels_;  ///< finest first
};

/// environment_from_world of an environment that is rotated about +Y, positive from +Z towards +X.
glm::dmat3 environment_rotation(double angle_rad);

/// Orthonormal non-standard two-dimensional Haar transform of each face, in place: [face][coefficient], the face's mean
/// first (times the side), then level by level from coarse to fine. `values`: side x side values a face, six faces.
/// Source: Stollnitz, DeRose and Salesin 1996, "Wavelets for Computer Graphics", Sec. 3.2 (non-standard decomposition).
void haar_transform_faces(int side, float* values);
void inverse_haar_faces(int side, float* values);

}  // namespace maquette
