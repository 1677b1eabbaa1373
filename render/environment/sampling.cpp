
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "render/environment/environment_tables.h"
#include "render/environment/texel_cell.h"
#include "render/math/low_discrepancy.h"
#include "scenes/parallel.h"

namespace maquette {
namespace {

/// The 3 x 3 texels of a map around one; rows are clamped at the poles, columns wrap.
class TexelsAround {
 public:
  TexelsAround(const Environment& environment, int x, int y) {
    const int width = environment.width;
    for (int j = 0; j < 3; ++j)
      rows_[j] = &environment.rgb[static_cast<std::size_t>(std::clamp(y + j - 1, 0, environment.height - 1)) *
                                  static_cast<std::size_t>(width)];
    columns_[0] = x == 0 ? width - 1 : x - 1;
    columns_[1] = x;
    columns_[2] = x + 1 == width ? 0 : x + 1;
  }
  /// Sum of the channels.
  double operator()(int dx, int dy) const {
    const glm::vec3& c = rows_[dy + 1][columns_[dx + 1]];
    return static_cast<double>(c.x) + static_cast<double>(c.y) + static_cast<double>(c.z);
  }

 private:
  const glm::vec3* rows_[3];
  int columns_[3];
};

/// One of the four nodes around a point of the map (nodes at integers).
struct SampledNode {
  glm::vec3 radiance{};
  float factor;  ///< probability of the selection, divided by the node's bilinear weight
};

/// Samples a node in proportion to bilinear weight times importance.
SampledNode sample_node(const PackedSky& sky, float x, float y, float u) {
  const auto below = [](float v) {
    return static_cast<int>(v) - (v < static_cast<float>(static_cast<int>(v)) ? 1 : 0);
  };
  const int x0 = below(x), y0 = below(y);
  const float a = x - static_cast<float>(x0), b = y - static_cast<float>(y0);
  const float shares[4] = {(1.0f - a) * (1.0f - b), a * (1.0f - b), (1.0f - a) * b, a * b};
  glm::vec3 nodes[4]{};
  float sums[4], begins[5] = {};  // channels; sums of the weights so far
  for (int k = 0; k < 4; ++k) {
    nodes[k] = sky.at(x0 + (k & 1), y0 + (k >> 1));
    sums[k] = nodes[k].x + nodes[k].y + nodes[k].z;
    begins[k + 1] = begins[k] + shares[k] * sums[k];
  }
  if (!(begins[4] > 0.0f)) return {glm::vec3(0.0f), 1.0f};  // the border of a cell without light
  // The last node that begins at or below `at`, among those of nonzero weight.
  const float at = u * begins[4];
  int chosen = 0;
  for (int k = 0; k < 4; ++k) chosen = begins[k] <= at && begins[k + 1] > begins[k] ? k : chosen;
  return {nodes[chosen], sums[chosen] / begins[4]};
}

}  // namespace

EnvironmentCell find_environment_cell(const float* cdf, std::size_t count, double u) {
  const float* end = cdf + count + 1;
  const float* after =
      std::upper_bound(cdf, end, u, [](double value, float entry) { return value < static_cast<double>(entry); });
  const std::size_t i = std::min(static_cast<std::size_t>(after - cdf), count) - 1;
  const double begin = cdf[i], size = static_cast<double>(cdf[i + 1]) - begin;
  return {i, size > 0.0 ? std::clamp((u - begin) / size, 0.0, 1.0) : 0.0};  // 0 where there is no light
}

EnvironmentPoint sample_environment_point(const EnvironmentTables& tables, double u, double v) {
  const auto width = static_cast<std::size_t>(tables.width);
  const EnvironmentCell row =
      find_environment_cell(tables.marginal_cdf.data(), static_cast<std::size_t>(tables.height), v);
  const EnvironmentCell column = find_environment_cell(&tables.conditional_cdf[row.index * (width + 1)], width, u);
  // A position of 1 must stay in its own column.
  return {row.index, static_cast<double>(column.index) + std::min(column.position, 1.0 - 1e-9), row.position};
}

namespace {

/// Samples directions within the cells of a map, in two steps, so that the memory accesses of several cells can
/// overlap.
class CellSampler {
 public:
  /// `many`: tabulates the sines and cosines of rows and columns.
  CellSampler(const Environment& environment, const EnvironmentTables& tables, bool many)
      : environment_(environment), tables_(tables) {
    if (!many || tables.width < kMinColumns) return;
    for (int y = 0; y <= tables.height; ++y) heights_.push_back(height_of(y));
    for (int x = 0; x < tables.width; ++x) centers_.push_back(heading_of(x + 0.5));
  }

  struct Cell {
    TexelCell shape;
    double density;
    int x, y;
  };
  Cell find(const EnvironmentPoint& point) const {
    const auto x = static_cast<int>(point.x), y = static_cast<int>(point.row);
    const std::size_t texel =
        static_cast<std::size_t>(y) * static_cast<std::size_t>(tables_.width) + static_cast<std::size_t>(x);
    return {TexelCell(TexelsAround(environment_, x, y)), static_cast<double>(tables_.density[texel]), x, y};
  }

  EnvironmentDirection draw(const Cell& cell, const EnvironmentPoint& point) const {
    const glm::dvec2 position = cell.shape.warp({point.x - cell.x, point.t});
    const double mean = cell.shape.mean();
    // Uniform in longitude and in the sine of the latitude.
    const bool known = !heights_.empty();
    const auto row = static_cast<std::size_t>(cell.y);
    const double top = known ? heights_[row] : height_of(cell.y);
    const double bottom = known ? heights_[row + 1] : height_of(cell.y + 1);
    const double up = std::clamp(top + (bottom - top) * position.y, -1.0, 1.0);
    const double r = std::sqrt(std::max(0.0, 1.0 - up * up));
    const glm::dvec2 heading = known ? heading_near(cell.x, position.x) : heading_of(cell.x + position.x);
    return {glm::vec3(glm::dvec3(heading.x * r, up, heading.y * r)),
            static_cast<float>(mean > 0.0 ? cell.density * cell.shape.at(position) / mean : cell.density),
            static_cast<float>(cell.x + position.x),
            static_cast<float>(std::acos(up) / std::numbers::pi * tables_.height)};
  }

 private:
  double height_of(int y) const { return std::cos(std::numbers::pi * y / tables_.height); }
  glm::dvec2 heading_of(double x) const {
    const double longitude = std::numbers::pi - 2.0 * std::numbers::pi * x / tables_.width;
    return {std::sin(longitude), std::cos(longitude)};
  }
  /// The same at a position in [0, 1] of a column: rotated from its centre by a Taylor series up to the seventh power;
  /// the next terms are below 1e-15 for kMinColumns.
  glm::dvec2 heading_near(int column, double position) const {
    const double d = 2.0 * std::numbers::pi * (0.5 - position) / tables_.width, d2 = d * d;
    const double sine = d * (1.0 - d2 * (1.0 / 6.0 - d2 * (1.0 / 120.0 - d2 * (1.0 / 5040.0))));
    const double cosine = 1.0 - d2 * (0.5 - d2 * (1.0 / 24.0 - d2 * (1.0 / 720.0)));
    const glm::dvec2& center = centers_[static_cast<std::size_t>(column)];
    return {center.x * cosine + center.y * sine, center.y * cosine - center.x * sine};
  }

  static constexpr int kMinColumns = 64;
  const Environment& environment_;
  const EnvironmentTables& tables_;
  std::vector<double> heights_;      ///< sine of the latitude of each row's upper border
  std::vector<glm::dvec2> centers_;  ///< sine and cosine of the longitude of each column's centre
};

/// Points of a scrambled low-discrepancy sequence, and an order in which neighbouring points follow each other: they
/// then share cells, and tables stay in the cache.
struct SortedPoints {
  struct Point {
    std::uint32_t index, u, v;
  };
  std::vector<Point> points;

  SortedPoints(std::uint32_t seed, std::size_t count) : points(count) {
    constexpr std::uint32_t kRows = 8, kColumns = 6;  // log2
    const std::uint32_t seeds[2] = {mix_seed(seed, 0), mix_seed(seed, 1)};
    std::vector<Point> unsorted(count);
    std::vector<std::uint32_t> ends((1u << (kRows + kColumns)) + 1);
    const auto bucket = [](const Point& p) { return p.v >> (32u - kRows) << kColumns | p.u >> (32u - kColumns); };
    for (std::uint32_t i = 0; i < count; ++i) {
      unsorted[i] = {i, owen_scramble(reverse_bits(i), seeds[0]),
                     owen_scramble(reverse_bits(sobol_second_reversed(i)), seeds[1])};
      ++ends[bucket(unsorted[i]) + 1];
    }
    for (std::size_t k = 1; k < ends.size(); ++k) ends[k] += ends[k - 1];
    for (const Point& p : unsorted) points[ends[bucket(p)]++] = p;
  }
};

}  // namespace

EnvironmentDirection sample_environment_direction(const Environment& environment, const EnvironmentTables& tables,
                                                  double u, double v) {
  const CellSampler cells(environment, tables, false);
  const EnvironmentPoint point = sample_environment_point(tables, u, v);
  return cells.draw(cells.find(point), point);
}

std::vector<EnvironmentSample> sample_environment(const Environment& environment, const EnvironmentTables& tables,
                                                  const PackedSky& sky, std::uint32_t seed, std::size_t count) {
  if (!(tables.luminance_integral > 0.0)) return {};
  const SortedPoints sorted(seed, count);
  std::vector<EnvironmentSample> samples(count);
  const float spacing = static_cast<float>(environment.width) / static_cast<float>(sky.columns);
  const CellSampler cells(environment, tables, true);
  // In batches, step by step, so that the batch prefetches the memory of all its samples.
  constexpr std::size_t kBatchSize = 32;
  parallel_ranges<std::size_t>(0, count, 2048, [&](const auto& range) {
    std::array<EnvironmentPoint, kBatchSize> points;
    std::array<EnvironmentDirection, kBatchSize> directions;
    std::vector<CellSampler::Cell> drawn_from;
    drawn_from.reserve(kBatchSize);
    for (std::size_t first = range.begin(); first < range.end(); first += kBatchSize) {
      const std::size_t n = std::min(kBatchSize, range.end() - first);
      const SortedPoints::Point* numbers = &sorted.points[first];
      for (std::size_t k = 0; k < n; ++k)
        points[k] = sample_environment_point(tables, numbers[k].u * 0x1p-32, numbers[k].v * 0x1p-32);
      drawn_from.clear();
      for (std::size_t k = 0; k < n; ++k) drawn_from.push_back(cells.find(points[k]));
      for (std::size_t k = 0; k < n; ++k) directions[k] = cells.draw(drawn_from[k], points[k]);
      for (std::size_t k = 0; k < n; ++k) {
        const auto& [direction, pdf, map_x, map_y] = directions[k];
        const std::uint32_t index = numbers[k].index;
        // A third dimension selects the node: additive recurrence with the golden ratio.
        const double w = (index * 0x9e3779b9u + mix_seed(seed, 2)) * 0x1p-32;
        const SampledNode node =
            sample_node(sky, map_x / spacing - sky.offset, map_y / spacing - sky.offset, static_cast<float>(w));
        samples[index] = {direction, pdf * node.factor, node.radiance, 0.0f};
      }
    }
  });
  return samples;
}

}  // namespace maquette
