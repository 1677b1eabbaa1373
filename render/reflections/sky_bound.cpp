#include "render/reflections/sky_bound.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>

#include "scenes/luminance.h"

namespace maquette {

namespace {

/// Cell of column x and row y of the environment.
std::size_t cell_of(const Environment& e, int x, int y) {
  const int column = std::clamp(x * SkyBound::kWidth / e.width, 0, SkyBound::kWidth - 1);
  const int row = std::clamp(y * SkyBound::kHeight / e.height, 0, SkyBound::kHeight - 1);
  return static_cast<std::size_t>(row * SkyBound::kWidth + column);
}

}  // namespace

SkyBound make_sky_bound(const Environment& e) {
  SkyBound sky;
  sky.largest.assign(SkyBound::kWidth * SkyBound::kHeight, 0.0f);
  const auto radiance = [&](int x, int y) {
    return channel_max(
        e.rgb[static_cast<std::size_t>(y) * static_cast<std::size_t>(e.width) + static_cast<std::size_t>(x)]);
  };
  std::vector<float> own(sky.largest.size(), 0.0f);  // maximum of the cell without its neighbours
  for (int y = 0; y < e.height; ++y)
    for (int x = 0; x < e.width; ++x) {
      const float v = radiance(x, y);
      own[cell_of(e, x, y)] = std::max(own[cell_of(e, x, y)], v);
      for (int dy = -1; dy <= 1; ++dy)
        for (int dx = -1; dx <= 1; ++dx) {
          float& cell = sky.largest[cell_of(e, (x + dx + e.width) % e.width, std::clamp(y + dy, 0, e.height - 1))];
          cell = std::max(cell, v);
        }
    }
  std::vector<std::size_t> order(own.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::partial_sort(order.begin(), order.begin() + SkyBound::kMaxLamps + 1, order.end(),
                    [&](std::size_t a, std::size_t b) { return own[a] > own[b]; });
  sky.level = own[order[SkyBound::kMaxLamps]];
  std::vector<double> excess(own.size(), 0.0);
  for (int y = 0; y < e.height; ++y) {
    const double band = std::cos(std::numbers::pi * y / e.height) - std::cos(std::numbers::pi * (y + 1) / e.height);
    for (int x = 0; x < e.width; ++x)
      excess[cell_of(e, x, y)] +=
          static_cast<double>(std::max(radiance(x, y) - sky.level, 0.0f)) * band * 2.0 * std::numbers::pi / e.width;
  }
  for (int k = 0; k < SkyBound::kMaxLamps; ++k) {
    const std::size_t cell = order[static_cast<std::size_t>(k)];
    if (excess[cell] <= 0.0) continue;
    const auto column = static_cast<double>(cell % SkyBound::kWidth),
               row = static_cast<double>(cell / SkyBound::kWidth);
    const glm::dvec3 middle = direction_from_latlong(column + 0.5, row + 0.5, SkyBound::kWidth, SkyBound::kHeight);
    const double side = std::numbers::pi / SkyBound::kHeight, texel = std::numbers::pi / e.height;
    sky.lamps.push_back(
        {glm::vec3(middle), static_cast<float>(0.7072 * side + 1.5 * texel), static_cast<float>(excess[cell])});
  }
  return sky;
}

}  // namespace maquette
