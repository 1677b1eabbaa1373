#include "scenes/texture_budget.h"

#include <algorithm>
#include <cmath>

#include "scenes/mip_chain.h"
#include "scenes/srgb.h"
#include "scenes/texels.h"

namespace maquette {

namespace {

/// Any file may have so many texels, two images of 4096 x 4096.
constexpr std::size_t kUsualTexels = std::size_t{1} << 25;
/// A byte of a PNG or JPEG image of a material holds one to ten texels.
constexpr std::size_t kTexelsOfByte = 16;
/// With mip chains 2^27: what a buffer texture of common drivers addresses.
constexpr std::size_t kMostTexels = std::size_t{3} << 25;

}  // namespace

std::size_t most_texels(std::size_t encoded_bytes) {
  return std::min(kMostTexels, kUsualTexels + kTexelsOfByte * std::min(encoded_bytes, kMostTexels));
}

std::vector<int> halvings_within(std::vector<glm::ivec2> sizes, std::size_t most) {
  std::vector<int> halvings(sizes.size(), 0);
  for (;;) {
    std::size_t sum = 0, largest = 0;
    for (const glm::ivec2& size : sizes) {
      sum += texels_of(size);
      largest = std::max(largest, texels_of(size));
    }
    if (sum <= most || largest <= 1) return halvings;
    for (std::size_t i = 0; i < sizes.size(); ++i) {
      if (2 * texels_of(sizes[i]) <= largest) continue;
      sizes[i] = glm::max(sizes[i] / 2, 1);
      ++halvings[i];
    }
  }
}

void halve_image(TextureImage* image, int times, bool srgb) {
  if (times < 1) return;
  const Texels texels(*image, srgb);
  MipLevel level = halve(image->width, image->height, texels);
  for (int i = 1; i < times; ++i) level = halve(level);
  const bool fine = !image->rgba16.empty();
  image->width = level.width;
  image->height = level.height;
  image->rgba.resize(4 * level.texels.size());
  image->rgba16.resize(fine ? 4 * level.texels.size() : 0);
  image->rgba.shrink_to_fit();
  image->rgba16.shrink_to_fit();
  parallel_for(std::size_t{0}, level.texels.size(), [&](std::size_t i) {
    for (int c = 0; c < 4; ++c) {
      const double value = static_cast<double>(level.texels[i][c]);
      const double code = srgb && c < 3 ? srgb_from_linear(value) : value;
      image->rgba[4 * i + static_cast<std::size_t>(c)] = static_cast<std::uint8_t>(std::lround(255.0 * code));
      if (fine)
        image->rgba16[4 * i + static_cast<std::size_t>(c)] = static_cast<std::uint16_t>(std::lround(65535.0 * code));
    }
  });
}

}  // namespace maquette
