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

/// Of a column up to one beyond either end, which wraps, and a row, which is clamped.
const glm::vec3& texel_around(const Environment& environment, int x, int y) {
  const int wrapped = x < 0 ? x + environment.width : x >= environment.width ? x - environment.width : x;
  const int clamped = std::clamp(y, 0, environment.height - 1);
  return environment.rgb[static_cast<std::size_t>(clamped) * static_cast<std::size_t>(environment.width) +
                         static_cast<std::size_t>(wrapped)];
}

/// One of the four nodes around a point of the map (nodes at whole numbers).
struct ChosenNode {
  glm::vec3 radiance;
  float factor;  ///< probability of the choice over the node's bilinear weight
};

/// Chosen in proportion to bilinear weight times importance.
ChosenNode choose_node(const PackedSky& sky, float x, float y, float u) {
  const float x0 = std::floor(x), y0 = std::floor(y), a = x - x0, b = y - y0;
  glm::vec3 nodes[4];
  float importance[4], weights[4], sum = 0.0f;
  for (int k = 0; k < 4; ++k) {
    nodes[k] = sky.at(static_cast<int>(x0) + (k & 1), static_cast<int>(y0) + (k >> 1));
    importance[k] = static_cast<float>(importance_of(nodes[k]));
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
  return {nodes[chosen], importance[chosen] / sum};
}

}  // namespace

EnvironmentCell find_environment_cell(const float* cdf, std::size_t count, double u) {
  const float* end = cdf + count + 1;
  const float* after =
      std::upper_bound(cdf, end, u, [](double value, float entry) { return value < static_cast<double>(entry); });
  const std::size_t i = std::min(static_cast<std::size_t>(after - cdf), count) - 1;
  const double begin = cdf[i], size = static_cast<double>(cdf[i + 1]) - begin;
  return {i, size > 0.0 ? std::clamp((u - begin) / size, 0.0, 1.0) : 0.0};  // where there is no light at all
}

EnvironmentPoint sample_environment_point(const EnvironmentTables& tables, double u, double v) {
  const auto width = static_cast<std::size_t>(tables.width);
  const EnvironmentCell row =
      find_environment_cell(tables.marginal_cdf.data(), static_cast<std::size_t>(tables.height), v);
  const EnvironmentCell column = find_environment_cell(&tables.conditional_cdf[row.index * (width + 1)], width, u);
  // A position of 1 stays in its own column.
  return {row.index, static_cast<double>(column.index) + std::min(column.position, 1.0 - 1e-9), row.position};
}

namespace {

/// Draws directions in one cell of the map after the other. What a cell is made of is kept until another one is drawn
/// from.
class CellSampler {
 public:
  CellSampler(const Environment& environment, const EnvironmentTables& tables)
      : environment_(environment), tables_(tables) {}

  EnvironmentDirection draw(const EnvironmentPoint& point) {
    const auto x = static_cast<int>(point.x), y = static_cast<int>(point.row);
    if (x != x_ || y != y_) enter(x, y);
    const glm::dvec2 place = cell_.warp({point.x - x, point.t});
    // Even in longitude and in the sine of the latitude.
    const double up = std::clamp(top_ + (bottom_ - top_) * place.y, -1.0, 1.0);
    const double r = std::sqrt(std::max(0.0, 1.0 - up * up));
    const double longitude = kPi - 2.0 * kPi * (x + place.x) / tables_.width;
    return {glm::vec3(glm::dvec3(std::sin(longitude) * r, up, std::cos(longitude) * r)),
            static_cast<float>(mean_ > 0.0 ? density_ * cell_.at(place) / mean_ : density_),
            static_cast<float>(x + place.x), static_cast<float>(std::acos(up) / kPi * tables_.height)};
  }

 private:
  void enter(int x, int y) {
    if (y != y_) {
      top_ = std::cos(kPi * y / tables_.height);
      bottom_ = std::cos(kPi * (y + 1) / tables_.height);
    }
    x_ = x;
    y_ = y;
    cell_ = TexelCell([&](int dx, int dy) { return importance_of(texel_around(environment_, x + dx, y + dy)); });
    mean_ = cell_.mean();
    density_ =
        static_cast<double>(tables_.density[static_cast<std::size_t>(y) * static_cast<std::size_t>(tables_.width) +
                                            static_cast<std::size_t>(x)]);
  }

  const Environment& environment_;
  const EnvironmentTables& tables_;
  int x_ = -1, y_ = -1;
  double top_ = 1.0, bottom_ = 1.0, mean_ = 0.0, density_ = 0.0;
  TexelCell cell_{[](int, int) { return 0.0; }};
};

/// Points of a scrambled low-discrepancy sequence, and an order in which those that fall near each other follow each
/// other: found so, they share cells, and tables stay in the cache.
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
  return CellSampler(environment, tables).draw(sample_environment_point(tables, u, v));
}

std::vector<EnvironmentSample> sample_environment(const Environment& environment, const EnvironmentTables& tables,
                                                  const PackedSky& sky, std::uint32_t seed, std::size_t count) {
  if (!(tables.luminance_integral > 0.0)) return {};
  const SortedPoints sorted(seed, count);
  std::vector<EnvironmentSample> samples(count);
  const float spacing = static_cast<float>(environment.width) / static_cast<float>(sky.columns);
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, count, 2048), [&](const auto& range) {
    CellSampler cells(environment, tables);
    for (std::size_t k = range.begin(); k < range.end(); ++k) {
      const auto [index, u, v] = sorted.points[k];
      const EnvironmentDirection d = cells.draw(sample_environment_point(tables, u * 0x1p-32, v * 0x1p-32));
      // A third dimension for the node: the golden ratio's additive recurrence.
      const double w = (index * 0x9e3779b9u + mix_seed(seed, 2)) * 0x1p-32;
      const ChosenNode node =
          choose_node(sky, d.map_x / spacing - sky.offset, d.map_y / spacing - sky.offset, static_cast<float>(w));
      samples[index] = {d.direction, d.pdf * node.factor, node.radiance, 0.0f};
    }
  });
  return samples;
}

}  // namespace maquette
