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

/// A value of texels (stored encoding, to 255) resampled to n x n by a box filter or nearest.
template <typename Value>
std::vector<float> resample(const TextureImage& image, std::size_t n, Value value) {
  std::vector<float> out(n * n);
  const auto w = static_cast<std::size_t>(image.width), h = static_cast<std::size_t>(image.height);
  for (std::size_t y = 0; y < n; ++y) {
    for (std::size_t x = 0; x < n; ++x) {
      const std::size_t x0 = x * w / n, x1 = std::max(x0 + 1, (x + 1) * w / n);
      const std::size_t y0 = y * h / n, y1 = std::max(y0 + 1, (y + 1) * h / n);
      float sum = 0.0f;
      for (std::size_t v = y0; v < y1; ++v)
        for (std::size_t u = x0; u < x1; ++u) sum += value(&image.rgba[4 * (v * w + u)]);
      out[y * n + x] = sum / (255.0f * static_cast<float>((x1 - x0) * (y1 - y0)));
    }
  }
  return out;
}

/// Energies of a region: [0] of its mean and what is coarser than a region, then of finer and finer details.
using Energies = std::array<double, 12>;

/// [region] of n x n values; `levels`: number of details.
std::vector<Energies> transform(std::vector<float> values, std::size_t n, std::size_t* levels) {
  constexpr std::size_t kSide = kTextureBandwidthSide;
  std::vector<Energies> energies(kSide * kSide, Energies{});
  std::size_t level = 0;
  for (std::size_t m = n; m > kSide; m /= 2) ++level;
  *levels = level;
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
  return energies;
}

/// The frequency below which 95 % of the energy lies.
float bandwidth_of(const Energies& energies, std::size_t levels) {
  constexpr std::size_t kSide = kTextureBandwidthSide;
  float result = 0.0f;
  double total = 0.0;
  for (double e : energies) total += e;
  double below = energies[0];
  // Details of level l (1 is the coarsest) cover half of kSide 2^(l - 1) cycles per unit up to all of it.
  for (std::size_t l = 1; l <= levels && below < 0.95 * total; ++l) {
    const double part = std::min(1.0, (0.95 * total - below) / std::max(energies[l], 1e-30));
    const double top = static_cast<double>(kSide) * std::exp2(static_cast<double>(l) - 1.0);
    result = static_cast<float>(0.5 * top + 0.5 * top * part);
    below += energies[l];
  }
  return result;
}

std::size_t side_of(const TextureImage& image) {
  return std::clamp<std::size_t>(std::bit_floor(static_cast<unsigned>(std::max(image.width, image.height))), 32, 512);
}

}  // namespace

std::vector<float> compute_texture_bandwidth(const TextureImage& image) {
  std::vector<float> result(kTextureBandwidthSide * kTextureBandwidthSide, 0.0f);
  if (image.width < 2 || image.height < 2) return result;
  const std::size_t n = side_of(image);
  std::size_t levels = 0;
  const std::vector<Energies> energies = transform(
      resample(image, n, [](const std::uint8_t* p) { return luminance(glm::vec3(p[0], p[1], p[2])); }), n, &levels);
  for (std::size_t r = 0; r < energies.size(); ++r) result[r] = bandwidth_of(energies[r], levels);
  return result;
}

namespace {

/// What the means of regions say of waves longer than two of them: where they bend, the frequency of a wave of their
/// deviation that bends so (1.6 times its own for long ones, exact for the shortest).
float coarse_bandwidth(const std::vector<float>& means, std::size_t x, std::size_t y) {
  constexpr std::size_t kSide = kTextureBandwidthSide;
  constexpr float kStep = 1.0f / 255.0f;
  const auto at = [&](std::size_t u, std::size_t v) { return means[v % kSide * kSide + u % kSide]; };
  const float own = at(x, y);
  const float bend = std::max(std::abs(at(x + 1, y) - 2.0f * own + at(x + kSide - 1, y)),
                              std::abs(at(x, y + 1) - 2.0f * own + at(x, y + kSide - 1)));
  if (bend < kStep) return 0.0f;
  float mean = 0.0f;
  for (const float m : means) mean += m / static_cast<float>(means.size());
  return 0.25f * static_cast<float>(kSide) * std::sqrt(std::min(bend / std::max(std::abs(own - mean), kStep), 4.0f));
}

/// Points are interpolated between others as far apart as half a wave: near an edge at a distance d these must not lie
/// beyond it, so that the bandwidth is at least 1 / (2 d) there.
std::vector<float> widened(const std::vector<float>& map) {
  constexpr int kSide = kTextureBandwidthSide;
  std::vector<float> wide = map;
  const auto apart = [](int a, int b) { return std::min(std::abs(a - b), kSide - std::abs(a - b)); };
  for (int from = 0; from < kSide * kSide; ++from) {
    const float own = map[static_cast<std::size_t>(from)];
    if (own == 0.0f) continue;
    for (int to = 0; to < kSide * kSide; ++to) {
      const int distance = std::max({apart(from % kSide, to % kSide), apart(from / kSide, to / kSide), 1});
      float& value = wide[static_cast<std::size_t>(to)];
      value = std::max(value, std::min(own, 0.5f * static_cast<float>(kSide) / static_cast<float>(distance)));
    }
  }
  return wide;
}

}  // namespace

std::vector<float> compute_data_bandwidth(const TextureImage& image, unsigned channels) {
  constexpr std::size_t kSide = kTextureBandwidthSide;
  std::vector<float> result(kSide * kSide, 0.0f);
  if ((image.width < 2 && image.height < 2) || channels == 0) return result;
  const std::size_t n = std::max<std::size_t>(side_of(image), 64);
  // Energy of a step in every value of a region.
  const double flat = static_cast<double>(n * n) / static_cast<double>(result.size()) / (255.0 * 255.0);
  for (unsigned c = 0; c < 4; ++c) {
    if ((channels >> c & 1u) == 0) continue;
    const auto value = [c](const std::uint8_t* p) { return static_cast<float>(p[c]); };
    std::size_t levels = 0;
    std::vector<Energies> energies = transform(resample(image, n, value), n, &levels);
    const std::vector<float> means = resample(image, kSide, value);
    for (std::size_t r = 0; r < energies.size(); ++r) {
      energies[r][0] = 0.0;
      double varies = 0.0;
      for (const double e : energies[r]) varies += e;
      result[r] = std::max({result[r], varies > flat ? bandwidth_of(energies[r], levels) : 0.0f,
                            coarse_bandwidth(means, r % kSide, r / kSide)});
    }
  }
  return widened(result);
}

unsigned data_channels(TextureRole role) {
  constexpr unsigned kRed = 1, kGreen = 2, kBlue = 4, kAlpha = 8;
  switch (role) {
    case TextureRole::base_color:
    case TextureRole::emissive:
    case TextureRole::normal:
      return 0;
    case TextureRole::metallic_roughness:
      return kGreen | kBlue;
    case TextureRole::clearcoat_roughness:
    case TextureRole::iridescence_thickness:
    case TextureRole::thickness:
      return kGreen;
    case TextureRole::clearcoat_normal:
      return kRed | kGreen;
    case TextureRole::specular:
    case TextureRole::sheen_roughness:
      return kAlpha;
    case TextureRole::specular_color:
    case TextureRole::sheen_color:
    case TextureRole::anisotropy:
      return kRed | kGreen | kBlue;
    default:
      return kRed;  // occlusion, clearcoat, iridescence, transmission
  }
}

}  // namespace maquette
