#include "render/reference/light_guide.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <numbers>

#include "render/math/low_discrepancy.h"
#include "render/math/wide.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

/// Summed-area table of the environment's importance.
class ImportanceSums {
 public:
  explicit ImportanceSums(const EnvironmentTables& tables) : stride_(static_cast<std::size_t>(tables.width) + 1) {
    sums_.assign(stride_ * (static_cast<std::size_t>(tables.height) + 1), 0.0);
    for (int y = 0; y < tables.height; ++y) {
      const float* cdf = &tables.conditional_cdf[static_cast<std::size_t>(y) * stride_];
      const double row = static_cast<double>(tables.marginal_cdf[static_cast<std::size_t>(y) + 1]) -
                         static_cast<double>(tables.marginal_cdf[static_cast<std::size_t>(y)]);
      for (int x = 0; x <= tables.width; ++x) at(x, y + 1) = at(x, y) + row * static_cast<double>(cdf[x]);
    }
  }
  double over(int x0, int y0, int x1, int y1) const { return at(x1, y1) - at(x0, y1) - at(x1, y0) + at(x0, y0); }

 private:
  double& at(int x, int y) { return sums_[static_cast<std::size_t>(y) * stride_ + static_cast<std::size_t>(x)]; }
  double at(int x, int y) const { return sums_[static_cast<std::size_t>(y) * stride_ + static_cast<std::size_t>(x)]; }
  std::size_t stride_;
  std::vector<double> sums_;
};

constexpr std::uint32_t kMostUseful = 255;  ///< fixed-point scale of the recorded squares
constexpr float kPlainShare = 0.1f;         ///< share of every cell's probability that follows the plain importance
/// Bounds that keep the density of every direction above 0: the least extent of a leaf, and how far below the horizon
/// (as a share of its extent) its axis is taken to be at most.
constexpr float kLeastExtent = 1e-3f, kLowest = 0.72f;

/// Cosines over a leaf lie within `extent` of the cosine of its axis. Returns their mean, clamped at the horizon, as if
/// they were uniformly distributed there.
inline float mean_facing(float cosine, float extent, float slope) {
  const float low = -kLowest * extent;
  const float bounded = cosine > low ? cosine : low;
  const float above = (bounded < extent ? bounded : extent) + extent;
  const float mean = above * above * slope;
  return mean > cosine ? mean : cosine;
}

/// Prior of a leaf before any ray was sent: this many rays, with this much of them useful.
constexpr float kPriorRays = 0.2f, kPriorUseful = 0.1f;

}  // namespace

EnvironmentPartition::EnvironmentPartition(const EnvironmentTables& tables) : width_(tables.width) {
  for (int y = 0; y <= tables.height; ++y) row_sines_.push_back(std::cos(std::numbers::pi * y / tables.height));
  const ImportanceSums sums(tables);
  const auto make = [&](int x0, int y0, int x1, int y1) {
    Leaf leaf{x0, y0, x1, y1, 0.0f, {}};
    leaf.probability = static_cast<float>(sums.over(x0, y0, x1, y1));
    return leaf;
  };
  leaves_.push_back(make(0, 0, tables.width, tables.height));
  // Repeatedly halves the leaf with the largest product of light and extent. Small or dark leaves stay whole.
  const auto urgency = [&](const Leaf& leaf) {
    const int side = std::max(leaf.x1 - leaf.x0, leaf.y1 - leaf.y0);
    return side > 1 ? leaf.probability * static_cast<float>(side) : 0.0f;
  };
  while (leaf_count() < kMostLeaves) {
    const auto next = std::max_element(leaves_.begin(), leaves_.end(),
                                       [&](const Leaf& a, const Leaf& b) { return urgency(a) < urgency(b); });
    if (!(urgency(*next) > 0.0f)) break;
    const Leaf l = *next;
    // Insert the second half beside the first: neighbours in the list are then neighbours in the map, so that samples
    // well distributed over the list are well distributed over the sky.
    if (l.x1 - l.x0 >= l.y1 - l.y0) {
      *next = make(l.x0, l.y0, (l.x0 + l.x1) / 2, l.y1);
      leaves_.insert(next + 1, make((l.x0 + l.x1) / 2, l.y0, l.x1, l.y1));
    } else {
      *next = make(l.x0, l.y0, l.x1, (l.y0 + l.y1) / 2);
      leaves_.insert(next + 1, make(l.x0, (l.y0 + l.y1) / 2, l.x1, l.y1));
    }
  }
  leaf_map_.resize(static_cast<std::size_t>(tables.width) * static_cast<std::size_t>(tables.height));
  for (std::size_t i = 0; i < leaves_.size(); ++i) {
    Leaf& leaf = leaves_[i];
    leaf.rows.push_back(0.0);
    for (int y = leaf.y0; y < leaf.y1; ++y) {
      leaf.rows.push_back(sums.over(leaf.x0, leaf.y0, leaf.x1, y + 1) /
                          std::max(sums.over(leaf.x0, leaf.y0, leaf.x1, leaf.y1), 1e-300));
      std::fill_n(leaf_map_.begin() + y * tables.width + leaf.x0, leaf.x1 - leaf.x0, static_cast<std::uint8_t>(i));
    }
  }
}

EnvironmentPoint EnvironmentPartition::sample(const EnvironmentTables& tables, int leaf, double u, double v) const {
  const Leaf& l = leaves_[static_cast<std::size_t>(leaf)];
  const auto after = std::upper_bound(l.rows.begin() + 1, l.rows.end() - 1, v);
  const EnvironmentCell row{static_cast<std::size_t>(after - l.rows.begin()) - 1,
                            std::clamp((v - after[-1]) / std::max(*after - after[-1], 1e-300), 0.0, 1.0)};
  const std::size_t y = static_cast<std::size_t>(l.y0) + row.index;
  const float* columns = &tables.conditional_cdf[y * (static_cast<std::size_t>(tables.width) + 1)] + l.x0;
  const auto count = static_cast<std::size_t>(l.x1 - l.x0);
  const double begin = columns[0], end = columns[count];
  const EnvironmentCell column = find_environment_cell(columns, count, begin + u * (end - begin));
  return {y, l.x0 + static_cast<double>(column.index) + std::min(column.position, 1.0 - 1e-9), row.position};
}

glm::vec3 EnvironmentPartition::direction(const EnvironmentPoint& point) const {
  // Uniform over the cell's solid angle: even in longitude and in the sine of the latitude.
  const double top = row_sines_[point.row], bottom = row_sines_[point.row + 1];
  const double y = std::clamp(top + (bottom - top) * point.t, -1.0, 1.0);
  const auto r = static_cast<float>(std::sqrt(std::max(0.0, 1.0 - y * y)));
  const auto longitude = static_cast<float>(std::numbers::pi - 2.0 * std::numbers::pi * point.x / width_);
  return {std::sin(longitude) * r, static_cast<float>(y), std::cos(longitude) * r};
}

glm::vec4 EnvironmentPartition::axis_and_extent(int leaf) const {
  const Leaf& l = leaves_[static_cast<std::size_t>(leaf)];
  constexpr int kSteps = 16;
  const auto at = [&](int column, int row) {
    const int texels = l.y1 - l.y0;
    const double y = l.y0 + static_cast<double>(texels) * row / kSteps;
    const auto whole = std::min(static_cast<std::size_t>(y), static_cast<std::size_t>(l.y1 - 1));
    return direction(
        {whole, l.x0 + static_cast<double>(l.x1 - l.x0) * column / kSteps, y - static_cast<double>(whole)});
  };
  const glm::vec3 axis = at(kSteps / 2, kSteps / 2);
  float extent = 0.0f;
  for (int i = 0; i <= kSteps; ++i)
    for (int k = 0; k <= kSteps; ++k) extent = std::max(extent, glm::length(at(i, k) - axis));
  return {axis, extent};
}

LeafShares::Choice LeafShares::last_with_light(int leaf) const {
  while (leaf > 0 && !(probability(leaf) > 0.0f)) --leaf;
  return {leaf, kLast, probability(leaf)};
}

LightGuide::LightGuide(const EnvironmentPartition& partition, const HashGrid& grid)
    : partition_(partition),
      grid_(grid),
      leaves_(partition.leaf_count()),
      records_(static_cast<std::size_t>(kCells) * kLeaves),
      openness_(kCells) {
  for (int leaf = 0; leaf < leaves_; ++leaf) {
    const std::size_t i = LeafShares::index_of(leaf);
    const glm::vec4 axis = partition.axis_and_extent(leaf);
    const float extent = std::max(axis.w, kLeastExtent);
    axes_.x[i] = axis.x;
    axes_.y[i] = axis.y;
    axes_.z[i] = axis.z;
    axes_.extent[i] = extent;
    axes_.slope[i] = 0.25f / extent;
    const float plain = partition.probability(leaf);
    inverse_plain_[static_cast<std::size_t>(leaf)] = plain > 0.0f ? 1.0f / plain : 0.0f;
  }
  shares_.resize(kCells);
  learn_cell(0);  // nothing is recorded yet: all cells are equal
  std::fill(shares_.begin() + 1, shares_.end(), shares_[0]);
}

float LightGuide::facing(int leaf, const glm::vec3& normal) const {
  const std::size_t i = LeafShares::index_of(leaf);
  return mean_facing(axes_.x[i] * normal.x + axes_.y[i] * normal.y + axes_.z[i] * normal.z, axes_.extent[i],
                     axes_.slope[i]);
}

MAQUETTE_WIDE void LightGuide::add_up(const CellShares& known, const Leaves& axes, const glm::vec3& normal,
                                      LeafShares* shares) {
  const float x = normal.x, y = normal.y, z = normal.z;
  // Local, so that the compiler knows that the loop does not write to what it reads.
  alignas(32) std::array<float, kLeaves> sums;
  for (std::size_t i = 0; i < kLeaves; ++i)
    sums[i] = static_cast<float>(known.units[i]) *
              mean_facing(axes.x[i] * x + axes.y[i] * y + axes.z[i] * z, axes.extent[i], axes.slope[i]);
  // A row of sums stays in one register. Stored one by one, the sums would go through the cache before they can be
  // loaded together.
  using Row = float __attribute__((vector_size(32)));
  static_assert(sizeof(Row) == LeafShares::kBlocks * sizeof(float));
  Row sum{};
  for (std::size_t i = 0; i < kLeaves; i += LeafShares::kBlocks) {
    std::memcpy(&shares->cumulative[i], &sum, sizeof sum);
    Row row;
    std::memcpy(&row, &sums[i], sizeof row);
    sum += row;
  }
  std::memcpy(&shares->cumulative[kLeaves], &sum, sizeof sum);
  const Row zero{};
  sum += __builtin_shufflevector(sum, zero, 8, 0, 1, 2, 3, 4, 5, 6);
  sum += __builtin_shufflevector(sum, zero, 8, 8, 0, 1, 2, 3, 4, 5);
  sum += __builtin_shufflevector(sum, zero, 8, 8, 8, 8, 0, 1, 2, 3);
  shares->begins[0] = 0.0f;
  std::memcpy(&shares->begins[1], &sum, sizeof sum);
}

void LightGuide::compute_shares(std::uint32_t cell, const glm::vec3& normal, LeafShares* shares) const {
  add_up(shares_[cell], axes_, normal, shares);
}

void LightGuide::record(std::uint32_t cell, int leaf, float useful) {
  const auto square = static_cast<std::uint64_t>(std::clamp(useful * useful, 0.0f, 1.0f) * kMostUseful + 0.5f);
  records_[at(cell, leaf)].fetch_add(square << 32 | 1u, std::memory_order_relaxed);
}

void LightGuide::learn() {
  if (!learning()) return;
  ++iterations_;
  parallel_for(std::uint32_t{0}, kCells, [&](std::uint32_t cell) {
    const auto* first = &records_[at(cell, 0)];
    if (std::any_of(first, first + kLeaves, [](const auto& n) { return n.load(std::memory_order_relaxed) > 0; }))
      learn_cell(cell);
  });
}

/// The optimal density of a stratum is proportional to the root of its mean square.
void LightGuide::learn_cell(std::uint32_t cell) {
  std::array<float, EnvironmentPartition::kMostLeaves> weights{};
  float sum = 0.0f, openness = 0.0f;
  for (int leaf = 0; leaf < leaves_; ++leaf) {
    const std::uint64_t record = records_[at(cell, leaf)].load(std::memory_order_relaxed);
    const float rays = static_cast<float>(record & 0xffffffffu);
    const float square = static_cast<float>(record >> 32) / static_cast<float>(kMostUseful);
    openness += rays > 0.0f ? partition_.probability(leaf) * square / rays : 0.0f;
    weights[static_cast<std::size_t>(leaf)] =
        partition_.probability(leaf) * std::sqrt((square + kPriorUseful) / (rays + kPriorRays));
    sum += weights[static_cast<std::size_t>(leaf)];
  }
  openness_[cell] = openness;
  float largest = 0.0f;
  for (int leaf = 0; leaf < leaves_; ++leaf) {
    const float plain = partition_.probability(leaf);
    float& weight = weights[static_cast<std::size_t>(leaf)];
    weight = (1.0f - kPlainShare) * (sum > 0.0f ? weight / sum : plain) + kPlainShare * plain;
    largest = std::max(largest, weight);
  }
  // At least one unit for every leaf with light, so that each can be sampled.
  for (int leaf = 0; leaf < leaves_; ++leaf) {
    const float units = weights[static_cast<std::size_t>(leaf)] / largest * 65535.0f;
    shares_[cell].units[LeafShares::index_of(leaf)] =
        static_cast<std::uint16_t>(partition_.probability(leaf) > 0.0f ? std::max(units, 1.0f) : 0.0f);
  }
}

}  // namespace maquette
