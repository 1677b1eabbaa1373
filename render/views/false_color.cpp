#include "render/views/false_color.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <vector>

#include "scenes/shared_glsl.h"

namespace maquette {
namespace shared {
#include "shared/false_color.glsl"
}  // namespace shared

FalseColorRange false_color_range(const Image& values, int channel) {
  assert(channel >= 0 && channel < values.channels);
  std::vector<float> finite;
  const auto stride = static_cast<std::size_t>(values.channels);
  for (std::size_t i = static_cast<std::size_t>(channel); i < values.data.size(); i += stride)
    if (std::isfinite(values.data[i])) finite.push_back(values.data[i]);
  if (finite.empty()) return {};
  const auto rank = static_cast<std::ptrdiff_t>(0.995 * static_cast<double>(finite.size() - 1));
  std::nth_element(finite.begin(), finite.begin() + rank, finite.end());
  const float high = finite[static_cast<std::size_t>(rank)];
  const float low = std::min(0.0f, *std::min_element(finite.begin(), finite.end()));
  return high > low ? FalseColorRange{low, high} : FalseColorRange{low, low + 1.0f};
}

Image false_color_image(const Image& values, std::optional<FalseColorRange> range, int channel) {
  assert(channel >= 0 && channel < values.channels);
  const FalseColorRange used = range ? *range : false_color_range(values, channel);
  Image result(values.width, values.height, 4, 1.0f);
  for (int y = 0; y < values.height; ++y) {
    for (int x = 0; x < values.width; ++x) {
      const float value = values.at(x, y, channel);
      const glm::vec3 rgb = std::isfinite(value)
                                ? shared::false_color(shared::false_color_linear(value, used.low, used.high))
                                : glm::vec3(1.0f, 0.0f, 1.0f);
      for (int c = 0; c < 3; ++c) result.at(x, y, c) = rgb[c];
      if (values.channels == 4 && channel != 3) result.at(x, y, 3) = values.at(x, y, 3);
    }
  }
  return result;
}

Image false_color_legend(int width, int height) {
  Image values(width, height, 1);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      values.at(x, y) = 1.0f - (static_cast<float>(y) + 0.5f) / static_cast<float>(height);
  return false_color_image(values, FalseColorRange{0.0f, 1.0f});
}

}  // namespace maquette
