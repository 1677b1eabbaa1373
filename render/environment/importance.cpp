#include "render/environment/importance.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "scenes/luminance.h"
#include "scenes/parallel.h"

namespace maquette {
namespace {

/// Importance and luminance of a texel, summed over the three rows that contribute to the cell's bilinear radiance.
struct Weighted {
  double importance;
  double luminance;
};

Weighted weigh(const glm::vec3& rgb, double weight) {
  const glm::dvec3 c(rgb);
  return {weight * (c.x + c.y + c.z) / 3.0, weight * luminance(c)};
}

/// Integrals of the cells of one row; returns the sum of the luminance.
double integrate_row(const Environment& environment, int y, std::vector<double>& cells) {
  const auto width = static_cast<std::size_t>(environment.width);
  const auto row = [&](int r) {
    return environment.rgb.data() + static_cast<std::size_t>(std::clamp(r, 0, environment.height - 1)) * width;
  };
  const RowWeights weights = row_weights(y, environment.width, environment.height);
  const glm::vec3 *above = row(y - 1), *here = row(y), *below = row(y + 1);
  std::vector<double> columns(width);
  double luminance = 0.0;
  for (std::size_t x = 0; x < width; ++x) {
    const Weighted a = weigh(above[x], weights.above), b = weigh(here[x], weights.here),
                   c = weigh(below[x], weights.below);
    columns[x] = a.importance + b.importance + c.importance;
    luminance += a.luminance + b.luminance + c.luminance;
  }
  for (std::size_t x = 0; x < width; ++x) {
    const std::size_t left = x == 0 ? width - 1 : x - 1;
    const std::size_t right = x + 1 == width ? 0 : x + 1;
    cells[x] = 0.125 * (columns[left] + columns[right]) + 0.75 * columns[x];
  }
  return luminance;
}

/// Normalised prefix sums of `weights`, from 0 to 1; linear when all weights are 0. Where there is weight they rise by
/// at least one float step, so that dim texels beside a sun of 1e6 times the sky are still sampled.
void write_cdf(const std::vector<double>& weights, double total, float* cdf) {
  const auto count = weights.size();
  double sum = 0.0;
  cdf[0] = 0.0f;
  for (std::size_t i = 0; i < count; ++i) {
    sum += weights[i];
    cdf[i + 1] = static_cast<float>(total > 0.0 ? std::min(sum / total, 1.0)
                                                : static_cast<double>(i + 1) / static_cast<double>(count));
  }
  cdf[count] = 1.0f;
  // Trailing cells without weight: their entries are exactly 1, whatever the division rounded to.
  if (total <= 0.0) return;
  std::size_t end = count;
  while (end > 0 && weights[end - 1] == 0.0) cdf[--end] = 1.0f;
  for (std::size_t i = 0; i < end; ++i)
    if (weights[i] > 0.0)
      cdf[i + 1] = std::max(cdf[i + 1], std::nextafter(cdf[i], 2.0f));
    else
      cdf[i + 1] = cdf[i];
  for (std::size_t i = end; i > 0; --i) {
    const float limit = i == end ? 1.0f : cdf[i];
    cdf[i] = limit;
    cdf[i - 1] = std::min(cdf[i - 1], weights[i - 1] > 0.0 ? std::nextafter(limit, 0.0f) : limit);
  }
}

double step_of(const float* cdf, std::size_t i) {
  return static_cast<double>(cdf[i + 1]) - static_cast<double>(cdf[i]);
}

}  // namespace

RowWeights row_weights(int y, int width, int height) {
  // 16-point midpoint rule over half a cell: relative error below 1e-4 of a weight in the polar row, far less
  // elsewhere.
  constexpr int kPoints = 16;
  const double row_rad = std::numbers::pi / height;
  RowWeights weights;
  for (int i = 0; i < 2 * kPoints; ++i) {
    const double t = (i + 0.5) / (2 * kPoints);  // 0 at the top of the cell, texel centre at 0.5
    const double measure = std::sin((y + t) * row_rad) * row_rad / (2 * kPoints) * 2.0 * std::numbers::pi / width;
    weights.above += measure * std::max(0.5 - t, 0.0);
    weights.below += measure * std::max(t - 0.5, 0.0);
    weights.here += measure * (1.0 - std::abs(t - 0.5));
  }
  const double exact = 2.0 * std::numbers::pi / width * (std::cos(y * row_rad) - std::cos((y + 1) * row_rad));
  const double scale = exact / weights.solid_angle();
  return {weights.above * scale, weights.here * scale, weights.below * scale};
}

void compute_importance(const Environment& environment, EnvironmentTables& tables) {
  const auto width = static_cast<std::size_t>(environment.width);
  const auto height = static_cast<std::size_t>(environment.height);
  tables.width = environment.width;
  tables.height = environment.height;
  tables.marginal_cdf.resize(height + 1);
  tables.conditional_cdf.resize(height * (width + 1));
  tables.density.resize(height * width);
  std::vector<double> row_sums(height), row_luminance(height);
  const auto conditional = [&](std::size_t y) { return &tables.conditional_cdf[y * (width + 1)]; };
  parallel_for(std::size_t{0}, height, [&](std::size_t y) {
    std::vector<double> cells(width);
    row_luminance[y] = integrate_row(environment, static_cast<int>(y), cells);
    for (const double cell : cells) row_sums[y] += cell;
    write_cdf(cells, row_sums[y], conditional(y));
  });
  double total = 0.0;
  tables.luminance_integral = 0.0;
  for (std::size_t y = 0; y < height; ++y) {
    total += row_sums[y];
    tables.luminance_integral += row_luminance[y];
  }
  write_cdf(row_sums, total, tables.marginal_cdf.data());
  // The density of the rounded prefix sums, because these are what is sampled.
  parallel_for(std::size_t{0}, height, [&](std::size_t y) {
    const double solid_angle = row_weights(static_cast<int>(y), environment.width, environment.height).solid_angle();
    const double scale = row_sums[y] > 0.0 ? step_of(tables.marginal_cdf.data(), y) / solid_angle : 0.0;
    for (std::size_t x = 0; x < width; ++x)
      tables.density[y * width + x] = static_cast<float>(scale * step_of(conditional(y), x));
  });
}

}  // namespace maquette
