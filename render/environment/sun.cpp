#include "render/environment/sun.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/math/low_discrepancy.h"
#include "render/math/shared_formulas.h"
#include "scenes/luminance.h"

namespace maquette {
namespace {

/// Limit of the solid angle of all suns together: four of 2 degrees diameter.
constexpr double kLargestSun_sr = 0.004;

struct SunTexel {
  std::size_t x, y;
  glm::vec3 radiance{};
  double power;  ///< luminance times the integral of its tent over the sphere
};

/// Integral of cos(latitude) over the tent around row y's centre, over the texels' extents: the tent's second moment
/// reduces it by 1/12 of the square of a row.
double tent_cosine(double y, const Environment& e) {
  const double row = std::numbers::pi / e.height, half = 0.5 * row;
  const double tent = std::pow(std::sin(half) / half, 2.0);  // transform of the tent at one cycle of the cosine
  return std::sin((y + 0.5) * row) * tent;
}

/// Position in a tent of half width 1, for u uniform in [0, 1].
double warp_tent(double u) { return u < 0.5 ? std::sqrt(2.0 * u) - 1.0 : 1.0 - std::sqrt(2.0 - 2.0 * u); }

EnvironmentSample sample_texel(const Environment& e, const SunTexel& texel, double integral, double u, double v) {
  const double x = static_cast<double>(texel.x) + 0.5 + warp_tent(u),
               y = static_cast<double>(texel.y) + 0.5 + warp_tent(v);
  const glm::dvec3 direction = direction_from_latlong(x, y, e.width, e.height);
  const double texel_sr = 2.0 * std::numbers::pi * std::numbers::pi / (static_cast<double>(e.width) * e.height) *
                          std::sin(std::numbers::pi * y / e.height);
  const double pdf = texel.power / integral / texel_sr;
  EnvironmentSample s;
  s.direction = glm::vec3(direction);
  s.pdf = static_cast<float>(pdf);
  s.radiance = glm::vec3(glm::dvec3(texel.radiance) / pdf);
  return s;
}

}  // namespace

float mean_sun_luminance(const Environment& e, double luminance_integral) {
  const double least = static_cast<double>(shared::kSunDensity) * luminance_integral;
  double sum = 0.0, squares = 0.0;
  for (std::size_t i = 0; i < e.rgb.size(); ++i) {
    const double l = luminance(e.rgb[i]);
    if (!(l > least)) continue;
    const double power = l * tent_cosine(static_cast<double>(i / static_cast<std::size_t>(e.width)), e);
    sum += power;
    squares += power * l;
  }
  return sum > 0.0 ? static_cast<float>(squares / sum) : 0.0f;
}

std::optional<Sun> find_sun(const Environment& environment, double luminance_integral, int bias, std::size_t samples) {
  if (!(luminance_integral > 0.0)) return std::nullopt;
  const double sun_luminance = static_cast<double>(shared::kSunDensity) * luminance_integral;
  const auto width = static_cast<std::size_t>(environment.width), height = static_cast<std::size_t>(environment.height);
  const double texel_sr = 2.0 * std::numbers::pi * std::numbers::pi / static_cast<double>(width * height);
  std::vector<SunTexel> texels;
  double solid_angle = 0.0, power = 0.0, dimmest = INFINITY, brightest = 0.0, brightest_other = 0.0;
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x) {
      const glm::vec3& c = environment.rgb[y * width + x];
      // Most texels are much darker: skip the packing.
      if (luminance(c) < 0.5 * sun_luminance) {
        brightest_other = std::max(brightest_other, static_cast<double>(luminance(c)));
        continue;
      }
      const glm::vec3 packed = shared::unpack_rgb9e5(shared::pack_rgb9e5(c, bias), bias);
      const double l = luminance(packed);
      if (l <= sun_luminance) {
        brightest_other = std::max(brightest_other, l);
        continue;
      }
      const double sr = texel_sr * tent_cosine(static_cast<double>(y), environment);
      solid_angle += sr;
      // The outermost rows at the poles are constant beyond their centres: no tent.
      if (y == 0 || y + 1 == height || solid_angle > kLargestSun_sr) return std::nullopt;
      texels.push_back({x, y, packed, l * sr});
      power += l * sr;
      dimmest = std::min(dimmest, l);
      brightest = std::max(brightest, l);
    }
  if (texels.empty()) return std::nullopt;
  Sun sun;
  sun.least_luminance = static_cast<float>(0.5 * (dimmest + brightest_other));
  sun.solid_angle_sr = power / brightest;
  std::vector<double> sums;
  double sum = 0.0;
  for (const SunTexel& t : texels) sums.push_back(sum += t.power);
  const std::uint32_t seeds[2] = {mix_seed(0x5u, 0), mix_seed(0x5u, 1)};
  for (std::size_t i = 0; i < samples; ++i) {
    const auto index = static_cast<std::uint32_t>(i);
    const double choice = owen_scramble(reverse_bits(index), seeds[0]) * 0x1p-32 * sum;
    const auto found = static_cast<std::size_t>(std::upper_bound(sums.begin(), sums.end(), choice) - sums.begin());
    const std::size_t k = std::min(found, texels.size() - 1);
    const double u = owen_scramble(reverse_bits(sobol_second_reversed(index)), seeds[1]) * 0x1p-32;
    const double v = (index * 0x9e3779b9u + mix_seed(0x5u, 2)) * 0x1p-32;
    sun.samples.push_back(sample_texel(environment, texels[k], sum, u, v));
  }
  const auto direction = [&](const SunTexel& t) {
    return direction_from_latlong(static_cast<double>(t.x) + 0.5, static_cast<double>(t.y) + 0.5, environment.width,
                                  environment.height);
  };
  for (const SunTexel& t : texels)
    sun.compact = sun.compact && glm::dot(direction(t), direction(texels[0])) > std::cos(std::numbers::pi / 90.0);
  auto rest = std::make_shared<Environment>(environment);
  for (const SunTexel& t : texels) rest->rgb[t.y * width + t.x] = glm::vec3(0.0f);
  sun.rest = std::move(rest);
  return sun;
}

}  // namespace maquette
