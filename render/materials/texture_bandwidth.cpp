#include "render/materials/texture_bandwidth.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include "render/math/daubechies4.h"
#include "scenes/luminance.h"

namespace maquette {

namespace {

/// One level of the Daubechies-4 transform of n periodic values with `stride`: averages first, then details.
void daubechies4_step(float* values, std::size_t n, std::size_t stride) {
  constexpr float h0 = kDaubechies4[0], h1 = kDaubechies4[1], h2 = kDaubechies4[2], h3 = kDaubechies4[3];
  std::vector<float> out(n);
  for (std::size_t i = 0; i < n / 2; ++i) {
    const auto v = [&](std::size_t k) { return values[(2 * i + k) % n * stride]; };
    out[i] = h0 * v(0) + h1 * v(1) + h2 * v(2) + h3 * v(3);
    out[n / 2 + i] = h3 * v(0) - h2 * v(1) + h1 * v(2) - h0 * v(3);
  }
  for (std::size_t i = 0; i < n; ++i) values[i * stride] = out[i];
}

/// Luminance (stored encoding) resampled to n x n by a box filter or nearest.
std::vector<float> resample(const TextureImage& image, std::size_t n) {
  std::vector<float> out(n * n);
  const auto w = static_cast<std::size_t>(image.width), h = static_cast<std::size_t>(image.height);
  for (std::size_t y = 0; y < n; ++y) {
    for (std::size_t x = 0; x < n; ++x) {
      const std::size_t x0 = x * w / n, x1 = std::max(x0 + 1, (x + 1) * w / n);
      const std::size_t y0 = y * h / n, y1 = std::max(y0 + 1, (y + 1) * h / n);
      float sum = 0.0f;
      for (std::size_t v = y0; v < y1; ++v)
        for (std::size_t u = x0; u < x1; ++u) {
          const std::uint8_t* p = &image.rgba[4 * (v * w + u)];
          sum += luminance(glm::vec3(p[0], p[1], p[2]));
        }
      out[y * n + x] = sum / (255.0f * static_cast<float>((x1 - x0) * (y1 - y0)));
    }
  }
  return out;
}

}  // namespace

std::vector<float> compute_texture_bandwidth(const TextureImage& image) {
  constexpr std::size_t kSide = kTextureBandwidthSide;
  std::vector<float> result(kSide * kSide, 0.0f);
  if (image.width < 2 || image.height < 2) return result;
  const auto largest = static_cast<unsigned>(std::max(image.width, image.height));
  const std::size_t n = std::clamp<std::size_t>(std::bit_floor(largest), 32, 512);
  std::vector<float> values = resample(image, n);
  std::vector<std::array<double, 12>> energies(kSide * kSide);  // per region: [0] mean and coarser, then finer levels
  std::size_t level_count = 0;
  for (std::size_t m = n; m > kSide; m /= 2) ++level_count;
  std::size_t level = level_count;
  for (std::size_t m = n; m > kSide; m /= 2, --level) {
    for (std::size_t y = 0; y < m; ++y) daubechies4_step(&values[y * n], m, 1);
    for (std::size_t x = 0; x < m; ++x) daubechies4_step(&values[x], m, n);
    for (std::size_t y = 0; y < m; ++y)
      for (std::size_t x = 0; x < m; ++x) {
        if (x < m / 2 && y < m / 2) continue;
        const std::size_t region = (y % (m / 2)) * kSide / (m / 2) * kSide + (x % (m / 2)) * kSide / (m / 2);
        energies[region][level] += static_cast<double>(values[y * n + x]) * values[y * n + x];
      }
  }
  for (std::size_t y = 0; y < kSide; ++y)
    for (std::size_t x = 0; x < kSide; ++x)
      energies[y * kSide + x][0] += static_cast<double>(values[y * n + x]) * values[y * n + x];
  for (std::size_t r = 0; r < energies.size(); ++r) {
    double total = 0.0;
    for (double e : energies[r]) total += e;
    double below = energies[r][0];
    // Details of level l (1 is the coarsest) cover half of kSide 2^(l - 1) cycles per unit up to all of it.
    for (std::size_t l = 1; l <= level_count && below < 0.95 * total; ++l) {
      const double part = std::min(1.0, (0.95 * total - below) / std::max(energies[r][l], 1e-30));
      const double top = static_cast<double>(kSide) * std::exp2(static_cast<double>(l) - 1.0);
      result[r] = static_cast<float>(0.5 * top + 0.5 * top * part);
      below += energies[r][l];
    }
  }
  return result;
}

}  // namespace maquette
