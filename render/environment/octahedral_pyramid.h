#pragma once

#include <vector>

#include "scenes/environment.h"

namespace maquette {

/// Averages of an environment over ever larger cells of the octahedral map (shaders/shared/octahedral.glsl): cells of
/// nearly equal and nearly round solid angle, poles included, which a latitude-longitude pyramid has not. Energy is
/// kept by every level.
class OctahedralPyramid {
 public:
  static constexpr int kMostCells = 1024;  ///< along a side
  /// `most_cells`: along a side of the finest level, a power of two from 16 to kMostCells; whoever looks up wide lobes
  /// alone needs few.
  explicit OctahedralPyramid(const Environment& environment, int most_cells = kMostCells);
  /// Mean radiance around a unit direction over about `solid_angle_sr`: bilinear, between two levels.
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
