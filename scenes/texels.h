#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "scenes/scene.h"

namespace maquette {

/// Texels of an image as linear values: in 16 bits where it has them. The image outlives it.
class Texels {
 public:
  /// `srgb`: colours are encoded by sRGB; alpha never is.
  Texels(const TextureImage& image, bool srgb);

  glm::vec4 operator()(int x, int y) const {
    const std::size_t at =
        4 * (static_cast<std::size_t>(y) * static_cast<std::size_t>(image_.width) + static_cast<std::size_t>(x));
    if (image_.rgba16.empty()) return decode(&image_.rgba[at]);
    return decode(&image_.rgba16[at]);
  }

 private:
  template <typename T>
  glm::vec4 decode(const T* texel) const {
    return {colour_[texel[0]], colour_[texel[1]], colour_[texel[2]], plain_[texel[3]]};
  }

  const TextureImage& image_;
  const float *colour_, *plain_;  ///< of each code
};

}  // namespace maquette
