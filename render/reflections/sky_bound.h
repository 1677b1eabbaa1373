#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "scenes/environment.h"

namespace maquette {

/// An environment as what it may light at most: no brighter than `level` but for a few lamps. The largest channel of
/// each; the environment's own frame, stored units.
struct SkyBound {
  struct Lamp {
    glm::vec3 direction{0.0f, 1.0f, 0.0f};
    float radius_rad = 0.0f;
    float irradiance = 0.0f;  ///< of what exceeds the level, on a surface that faces it
  };
  static constexpr int kWidth = 128, kHeight = 64, kMostLamps = 48;
  float level = 0.0f;
  std::vector<Lamp> lamps;
  std::vector<float> largest;  ///< [kHeight][kWidth] of a cell, what the bilinear lookup mixes in included
};
SkyBound make_sky_bound(const Environment& environment);

}  // namespace maquette
