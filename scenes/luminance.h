#pragma once

#include <algorithm>

#include "scenes/image.h"
#include "scenes/shared_glsl.h"

namespace maquette {

namespace shared {
#include "shared/luminance.glsl"
}  // namespace shared

using shared::luminance;

/// The same in double.
inline double luminance(const glm::dvec3& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

/// The largest of red, green and blue.
inline float channel_max(const glm::vec3& c) { return std::max({c.x, c.y, c.z}); }

/// Of a pixel of at least three channels.
inline double luminance(const Image& image, int x, int y) {
  const float* p = &image.data[image.index(x, y)];
  return luminance(glm::dvec3(p[0], p[1], p[2]));
}

}  // namespace maquette
