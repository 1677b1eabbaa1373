#include "render/picture/tonemap.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <numbers>

#include "scenes/error.h"
#include "scenes/luminance.h"
#include "scenes/parallel.h"

namespace maquette {
namespace shared {
#include "shared/tonemap.glsl"
}  // namespace shared

namespace {

constexpr double kGrey = 0.18;
constexpr double kGreyTarget =
    0.20;                           ///< linear display value of a lit 18 % grey: a little above the photographic middle
constexpr double kSkyLimit = 0.65;  ///< linear display value that the sky's log-average may reach

struct LightSums {
  double flux = 0.0;       ///< luminance times solid angle over the sphere
  glm::dvec3 vector{0.0};  ///< the same times direction
};

LightSums sum_light(const Environment& environment) {
  const auto width = static_cast<std::size_t>(environment.width);
  std::vector<glm::dvec3> around(width);  // horizontal directions of the columns
  for (std::size_t x = 0; x < width; ++x)
    around[x] = direction_from_latlong(static_cast<double>(x) + 0.5, 0.5, environment.width, 1);
  std::vector<LightSums> rows(static_cast<std::size_t>(environment.height));
  parallel_for(std::size_t{0}, rows.size(), [&](std::size_t y) {
    const double theta = std::numbers::pi * (static_cast<double>(y) + 0.5) / environment.height;
    const double solid_angle =
        std::sin(theta) * std::numbers::pi / environment.height * 2.0 * std::numbers::pi / environment.width;
    LightSums& row = rows[y];
    for (std::size_t x = 0; x < width; ++x) {
      const double value = luminance(glm::dvec3(environment.rgb[y * width + x]));
      row.flux += value;
      row.vector += value * around[x];
    }
    row.vector = solid_angle * (std::sin(theta) * row.vector + glm::dvec3(0.0, std::cos(theta) * row.flux, 0.0));
    row.flux *= solid_angle;
  });
  LightSums sums;
  for (const LightSums& row : rows) {
    sums.flux += row.flux;
    sums.vector += row.vector;
  }
  return sums;
}

/// Log-average luminance over the sphere, from at most about 32,768 texels; black counts as 1e-4 of `mean`.
double log_average(const Environment& environment, double mean) {
  const int step = std::max(1, static_cast<int>(std::sqrt(static_cast<double>(environment.rgb.size()) / 32768.0)));
  double sum = 0.0, weights = 0.0;
  for (int y = step / 2; y < environment.height; y += step) {
    const double weight = std::sin(std::numbers::pi * (y + 0.5) / environment.height);
    for (int x = step / 2; x < environment.width; x += step) {
      const auto i =
          static_cast<std::size_t>(y) * static_cast<std::size_t>(environment.width) + static_cast<std::size_t>(x);
      sum += weight * std::log(std::max(1e-4 * mean, luminance(glm::dvec3(environment.rgb[i]))));
      weights += weight;
    }
  }
  return std::exp(sum / weights);
}

}  // namespace

const std::vector<std::string>& tonemap_names() {
  static const std::vector<std::string> kNames = {"linear", "reinhard", "aces", "agx", "pbr-neutral"};
  return kNames;
}

double mean_luminance(const Environment& environment) { return sum_light(environment).flux / (4.0 * std::numbers::pi); }

float meter_exposure_ev(const Image& radiance, float environment_ev) {
  constexpr double kTarget = 0.1, kGlare = 0.3, kFloor = 0.004;  // of the display's linear range
  constexpr float kMaxStops = 5.0f;
  constexpr double kFall = 1.5;  // of the weights: 0.22 in the middle of an edge, 0.05 in a corner
  if (radiance.channels < 3) return environment_ev;
  const double scale = std::exp2(static_cast<double>(environment_ev));
  double sum = 0.0, weights = 0.0;
  const auto across = [](int i, int size) { return (2.0 * i + 1.0) / size - 1.0; };
  for (int y = 0; y < radiance.height; ++y) {
    for (int x = 0; x < radiance.width; ++x) {
      if (radiance.channels > 3 && radiance.at(x, y, 3) < 1.0f) continue;
      const double value = scale * luminance(radiance, x, y);
      if (!std::isfinite(value)) continue;
      const double u = across(x, radiance.width), v = across(y, radiance.height),
                   weight = std::exp(-kFall * (u * u + v * v));
      sum += weight * std::log2(std::max(value, 0.0) + kFloor);
      weights += weight;
    }
  }
  if (!(weights > 0.0)) return environment_ev;
  const double average = sum / weights;
  const auto stops = static_cast<float>(average > std::log2(kGlare) ? std::log2(kGlare) - average
                                                                    : std::max(std::log2(kTarget) - average, 0.0));
  return environment_ev + std::min(stops, kMaxStops);
}

int tonemap_index(const std::string& name) {
  const auto& names = tonemap_names();
  const auto found = std::find(names.begin(), names.end(), name);
  if (found == names.end()) {
    std::string all;
    for (const std::string& known : names) all += (all.empty() ? "" : ", ") + known;
    throw UsageError("--tonemap", "no tone mapper \"" + name + "\"", "use one of " + all);
  }
  return static_cast<int>(found - names.begin());
}

Image tone_map(const Image& points, float exposure_ev, const std::string& tonemap, int side) {
  assert(points.channels >= 3 && side > 0 && points.width % side == 0 && points.height % side == 0);
  const int curve = tonemap_index(tonemap);
  const float exposure = std::exp2(exposure_ev), share = 1.0f / static_cast<float>(side * side);
  Image result(points.width / side, points.height / side, points.channels);
  parallel_for(0, result.height, [&](int y) {
    for (int x = 0; x < result.width; ++x) {
      glm::vec3 sum(0.0f);
      float alpha = 0.0f;
      for (int k = 0; k < side * side; ++k) {
        const float* p = &points.data[points.index(x * side + k % side, y * side + k / side)];
        sum += shared::tonemap({p[0], p[1], p[2]}, exposure, curve);
        if (points.channels > 3) alpha += std::clamp(p[3], 0.0f, 1.0f);
      }
      const glm::vec3 display = shared::srgb_encode(sum * share);
      for (int c = 0; c < 3; ++c) result.at(x, y, c) = display[c];
      if (points.channels > 3) result.at(x, y, 3) = alpha * share;
    }
  });
  return result;
}

float suggest_exposure_ev(const Environment& environment) {
  const LightSums sums = sum_light(environment);
  if (!(sums.flux > 0.0)) return 0.0f;
  // On a plane that faces the light: the vector irradiance for a sun, a quarter of the flux for a uniform sky.
  const double irradiance = std::max(glm::length(sums.vector), sums.flux / 4.0);
  const double lit_grey = kGrey * irradiance / std::numbers::pi;
  const double exposure =
      std::min(kGreyTarget / lit_grey, kSkyLimit / log_average(environment, sums.flux / (4.0 * std::numbers::pi)));
  return static_cast<float>(std::clamp(std::log2(exposure), -40.0, 40.0));
}

}  // namespace maquette
