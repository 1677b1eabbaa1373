#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "scenes/environment.h"

namespace maquette {

/// Upper bound of an environment: no brighter than `level` except for a few lamps. Largest channel of each; in the
/// environment's own frame, stored units.
struct SkyBound {
  struct Lamp {
    glm::vec3 direction{0.0f, 1.0f, 0.0f};
    float radius_rad = 0.0f;
    float irradiance = 0.0f;  ///< of the excess over `level`, on a surface that faces it
  };
  static constexpr int kWidth = 128, kHeight = 64, kMaxLamps = 48;
  float level = 0.0f;
  std::vector<Lamp> lamps;
  std::vector<float> largest;  ///< [kHeight][kWidth] maximum of a cell and of the neighbours that bilinear lookup uses
};
SkyBound make_sky_bound(const Environment& environment);

}  // namespace maquette
