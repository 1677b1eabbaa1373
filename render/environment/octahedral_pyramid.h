#pragma once

#include <vector>

#include "scenes/environment.h"

namespace maquette {

/// Mip pyramid of an environment in the octahedral map (shaders/shared/octahedral.glsl). Unlike the texels of a
/// latitude-longitude pyramid its cells have nearly equal solid angle and a nearly round shape, poles included. Every
/// level conserves energy.
class OctahedralPyramid {
 public:
  static constexpr int kMaxSide = 1024;  ///< along a side
  /// `max_side`: cells along a side of the finest level, a power of two from 16 to kMaxSide. Lookups of wide lobes
  /// alone need few.
  explicit OctahedralPyramid(const Environment& environment, int max_side = kMaxSide);
  /// Mean radiance over about `solid_angle_sr` around a unit direction: bilinear, interpolated between two levels.
  glm::vec3 lookup(const glm::vec3& direction, float solid_angle_sr) const;

 private:
  struct Level {
    int side = 0;
    std::vector<glm::vec4> cells;  ///< mean radiance, solid angle
  };
  static glm::vec3 bilinear(const Level& level, const glm::vec2& uv);
  std::vector<Level> levels_;  ///< finest first, down to 2 x 2
};

}  // namespace maquette
