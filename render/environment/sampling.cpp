#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/environment/environment_tables.h"
#include "render/environment/texel_cell.h"
#include "render/low_discrepancy.h"

namespace maquette {
namespace {

constexpr double kPi = std::numbers::pi;

double importance_of(const glm::vec3& radiance) {
  return (static_cast<double>(radiance.x) + static_cast<double>(radiance.y) + static_cast<double>(radiance.z)) / 3.0;
}

/// One of the four texels around a point of the map (texel centres at whole numbers).
struct ChosenTexel {
  glm::vec3 radiance;
  float factor;  ///< probability of the choice over the texel's bilinear weight
};

/// Chosen in proportion to bilinear weight times importance.
ChosenTexel choose_texel(const Environment& environment, float x, float y, float u) {
  const float x0 = std::floor(x), y0 = std::floor(y), a = x - x0, b = y - y0;
  glm::vec3 texels[4];
  float importance[4], weights[4], sum = 0.0f;
  for (int k = 0; k < 4; ++k) {
    const int column = static_cast<int>(x0) + (k & 1), row = static_cast<int>(y0) + (k >> 1);
    const auto wrapped = static_cast<std::size_t>((column + environment.width) % environment.width);
    const auto clamped = static_cast<std::size_t>(std::clamp(row, 0, environment.height - 1));
    texels[k] = environment.rgb[clamped * static_cast<std::size_t>(environment.width) + wrapped];
    importance[k] = (texels[k].x + texels[k].y + texels[k].z) / 3.0f;
    weights[k] = (k & 1 ? a : 1.0f - a) * (k >> 1 ? b : 1.0f - b) * importance[k];
    sum += weights[k];
  }
  int chosen = -1;
  for (int k = 0; k < 4; ++k) {
    if (!(weights[k] > 0.0f)) continue;
    chosen = k;
    u -= weights[k] / sum;
    if (u < 0.0f) break;
  }
  if (chosen < 0) return {glm::vec3(0.0f), 1.0f};  // a cell's border without light
  return {texels[chosen], importance[chosen] / sum};
}

}  // namespace

EnvironmentCell find_environment_cell(const float* cdf, std::size_t count, double u) {
  const float* end = cdf + count + 1;
  const float* after =
      std::upper_bound(cdf, end, u, [](double value, float entry) { return value < static_cast<double>(entry); });
  const std::size_t i = std::min(static_cast<std::size_t>(after - cdf), count) - 1;
  const double begin = cdf[i];
  return {i, std::clamp((u - begin) / (static_cast<double>(cdf[i + 1]) - begin), 0.0, 1.0)};
}

EnvironmentPoint sample_environment_point(const EnvironmentTables& tables, double u, double v) {
  const auto width = static_cast<std::size_t>(tables.width);
  const EnvironmentCell row =
      find_environment_cell(tables.marginal_cdf.data(), static_cast<std::size_t>(tables.height), v);
  const EnvironmentCell column = find_environment_cell(&tables.conditional_cdf[row.index * (width + 1)], width, u);
  // A position of 1 stays in its own column.
  return {row.index, static_cast<double>(column.index) + std::min(column.position, 1.0 - 1e-9), row.position};
}

EnvironmentDirection sample_environment_direction(const Environment& environment, const EnvironmentTables& tables,
                                                  double u, double v) {
  const auto [row, column, t] = sample_environment_point(tables, u, v);
  const int width = tables.width, height = tables.height;
  const auto x = static_cast<int>(column), y = static_cast<int>(row);
  const TexelCell cell([&](int dx, int dy) {
    const auto at_x = static_cast<std::size_t>((x + dx + width) % width);
    const auto at_y = static_cast<std::size_t>(std::clamp(y + dy, 0, height - 1));
    return importance_of(environment.rgb[at_y * static_cast<std::size_t>(width) + at_x]);
  });
  const glm::dvec2 place = cell.warp({column - x, t});
  const double mean = cell.mean();
  // Even in longitude and in the sine of the latitude.
  const double top = std::cos(kPi * y / height), bottom = std::cos(kPi * (y + 1) / height);
  const double up = std::clamp(top + (bottom - top) * place.y, -1.0, 1.0);
  const double r = std::sqrt(std::max(0.0, 1.0 - up * up)), longitude = kPi - 2.0 * kPi * (x + place.x) / width;
  const auto density =
      static_cast<double>(tables.density[row * static_cast<std::size_t>(width) + static_cast<std::size_t>(x)]);
  return {glm::vec3(glm::dvec3(std::sin(longitude) * r, up, std::cos(longitude) * r)),
          static_cast<float>(mean > 0.0 ? density * cell.at(place) / mean : density), static_cast<float>(x + place.x),
          static_cast<float>(std::acos(up) / kPi * height)};
}

std::vector<EnvironmentSample> sample_environment(const Environment& environment, const EnvironmentTables& tables,
                                                  std::uint32_t seed, std::size_t count) {
  if (!(tables.luminance_integral > 0.0)) return {};
  const std::uint32_t seeds[2] = {mix_seed(seed, 0), mix_seed(seed, 1)};
  std::vector<EnvironmentSample> samples(count);
  tbb::parallel_for(std::size_t{0}, count, [&](std::size_t i) {
    const auto index = static_cast<std::uint32_t>(i);
    const double u = owen_scramble(reverse_bits(index), seeds[0]) * 0x1p-32;
    const double v = owen_scramble(reverse_bits(sobol_second_reversed(index)), seeds[1]) * 0x1p-32;
    const EnvironmentDirection d = sample_environment_direction(environment, tables, u, v);
    // A third dimension for the texel: the golden ratio's additive recurrence.
    const double w = (index * 0x9e3779b9u + mix_seed(seed, 2)) * 0x1p-32;
    const ChosenTexel texel = choose_texel(environment, d.map_x - 0.5f, d.map_y - 0.5f, static_cast<float>(w));
    samples[i] = {d.direction, d.pdf * texel.factor, texel.radiance, 0.0f};
  });
  return samples;
}

}  // namespace maquette
