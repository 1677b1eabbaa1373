#include "render/reference/light_guide.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "render/low_discrepancy.h"

namespace maquette {

namespace {

/// Sums of the importance over rectangles.
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

constexpr std::uint32_t kMostUseful = 255;  ///< fixed point of the recorded squares
constexpr float kPlainShare = 0.1f;         ///< of every cell's probability
/// What a leaf counts as before any ray was sent: so many rays, so much of them useful.
constexpr float kPriorRays = 2.0f, kPriorUseful = 0.1f;
/// Side of a cell over its distance from the eye.
constexpr float kCellAngle = 0.12f;

}  // namespace

EnvironmentPartition::EnvironmentPartition(const EnvironmentTables& tables) : width_(tables.width) {
  const ImportanceSums sums(tables);
  const auto make = [&](int x0, int y0, int x1, int y1) {
    Leaf leaf{x0, y0, x1, y1, 0.0f, {}};
    leaf.probability = static_cast<float>(sums.over(x0, y0, x1, y1));
    return leaf;
  };
  leaves_.push_back(make(0, 0, tables.width, tables.height));
  // The leaf with the most light times extent is halved, until there are enough; what is small or dark stays whole.
  const auto urgency = [&](const Leaf& leaf) {
    const int side = std::max(leaf.x1 - leaf.x0, leaf.y1 - leaf.y0);
    return side > 1 ? leaf.probability * static_cast<float>(side) : 0.0f;
  };
  while (leaf_count() < kMostLeaves) {
    const auto next = std::max_element(leaves_.begin(), leaves_.end(),
                                       [&](const Leaf& a, const Leaf& b) { return urgency(a) < urgency(b); });
    if (!(urgency(*next) > 0.0f)) break;
    const Leaf l = *next;
    if (l.x1 - l.x0 >= l.y1 - l.y0) {
      *next = make(l.x0, l.y0, (l.x0 + l.x1) / 2, l.y1);
      leaves_.push_back(make((l.x0 + l.x1) / 2, l.y0, l.x1, l.y1));
    } else {
      *next = make(l.x0, l.y0, l.x1, (l.y0 + l.y1) / 2);
      leaves_.push_back(make(l.x0, (l.y0 + l.y1) / 2, l.x1, l.y1));
    }
  }
  leaf_map_.resize(static_cast<std::size_t>(tables.width) * static_cast<std::size_t>(tables.height));
  for (std::size_t i = 0; i < leaves_.size(); ++i) {
    Leaf& leaf = leaves_[i];
    leaf.rows.push_back(0.0f);
    for (int y = leaf.y0; y < leaf.y1; ++y) {
      leaf.rows.push_back(static_cast<float>(sums.over(leaf.x0, leaf.y0, leaf.x1, y + 1) /
                                             std::max(sums.over(leaf.x0, leaf.y0, leaf.x1, leaf.y1), 1e-300)));
      std::fill_n(leaf_map_.begin() + y * tables.width + leaf.x0, leaf.x1 - leaf.x0, static_cast<std::uint8_t>(i));
    }
  }
}

EnvironmentDirection EnvironmentPartition::sample(const EnvironmentTables& tables, int leaf, double u, double v) const {
  const Leaf& l = leaves_[static_cast<std::size_t>(leaf)];
  const EnvironmentCell row = find_environment_cell(l.rows.data(), l.rows.size() - 1, v);
  const std::size_t y = static_cast<std::size_t>(l.y0) + row.index;
  const float* columns = &tables.conditional_cdf[y * (static_cast<std::size_t>(tables.width) + 1)] + l.x0;
  const auto count = static_cast<std::size_t>(l.x1 - l.x0);
  const double begin = columns[0], end = columns[count];
  const EnvironmentCell column = find_environment_cell(columns, count, begin + u * (end - begin));
  return environment_direction(
      tables, y, l.x0 + static_cast<double>(column.index) + std::min(column.position, 1.0 - 1e-9), row.position);
}

LightGuide::LightGuide(const EnvironmentPartition& partition, const glm::vec3& eye, float scene_radius)
    : partition_(partition),
      eye_(eye),
      finest_m_(std::max(scene_radius * 1e-3f, 1e-30f)),
      leaves_(partition.leaf_count()),
      tries_(static_cast<std::size_t>(kCells) * static_cast<std::size_t>(leaves_)),
      useful_(tries_.size()),
      cumulative_(tries_.size()) {
  tbb::parallel_for(std::uint32_t{0}, kCells, [&](std::uint32_t cell) { learn_cell(cell); });
}

std::uint32_t LightGuide::cell_of(const glm::vec3& position, const glm::vec3& normal) const {
  // Sides in powers of two of the finest, so that places near each other agree.
  const float wanted = std::max(kCellAngle * glm::length(position - eye_) / finest_m_, 1.0f);
  const int level = std::min(static_cast<int>(std::log2(wanted)), 20);
  const glm::vec3 cell = glm::floor(position / (finest_m_ * static_cast<float>(1 << level)));
  const glm::vec3 a = glm::abs(normal);
  const int axis = a.x >= a.y && a.x >= a.z ? 0 : a.y >= a.z ? 1 : 2;
  const int facing = 2 * axis + (normal[axis] < 0.0f ? 1 : 0);
  std::uint32_t key = mix_seed(static_cast<std::uint32_t>(facing), static_cast<std::uint32_t>(level));
  for (int c = 0; c < 3; ++c)
    key = mix_seed(key, static_cast<std::uint32_t>(static_cast<std::int32_t>(std::clamp(cell[c], -2e9f, 2e9f))));
  return key & (kCells - 1);
}

int LightGuide::choose_leaf(std::uint32_t cell, float* u) const {
  const float* begin = &cumulative_[at(cell, 0)];
  const float* found = std::upper_bound(begin, begin + leaves_ - 1, *u);
  const float before = found == begin ? 0.0f : found[-1];
  *u = std::clamp((*u - before) / std::max(*found - before, 1e-20f), 0.0f, 0x1.fffffep-1f);
  return static_cast<int>(found - begin);
}

float LightGuide::gain(std::uint32_t cell, int leaf) const {
  const std::size_t i = at(cell, leaf);
  const float own = leaf == 0 ? cumulative_[i] : cumulative_[i] - cumulative_[i - 1];
  const float plain = partition_.probability(leaf);
  return plain > 0.0f ? own / plain : 0.0f;
}

void LightGuide::record(std::uint32_t cell, int leaf, float useful) {
  const std::size_t i = at(cell, leaf);
  tries_[i].fetch_add(1, std::memory_order_relaxed);
  const auto square = static_cast<std::uint32_t>(std::clamp(useful * useful, 0.0f, 1.0f) * kMostUseful + 0.5f);
  if (square > 0) useful_[i].fetch_add(square, std::memory_order_relaxed);
}

void LightGuide::learn() {
  tbb::parallel_for(std::uint32_t{0}, kCells, [&](std::uint32_t cell) {
    const auto* first = &tries_[at(cell, 0)];
    if (std::any_of(first, first + leaves_, [](const auto& n) { return n.load(std::memory_order_relaxed) > 0; }))
      learn_cell(cell);
  });
}

/// The best density for one part of a sum is its root mean square.
void LightGuide::learn_cell(std::uint32_t cell) {
  std::array<float, EnvironmentPartition::kMostLeaves> weights{};
  float sum = 0.0f;
  for (int leaf = 0; leaf < leaves_; ++leaf) {
    const std::size_t i = at(cell, leaf);
    const float rays = static_cast<float>(tries_[i].load(std::memory_order_relaxed)) + kPriorRays;
    const float square =
        static_cast<float>(useful_[i].load(std::memory_order_relaxed)) / static_cast<float>(kMostUseful) + kPriorUseful;
    weights[static_cast<std::size_t>(leaf)] = partition_.probability(leaf) * std::sqrt(square / rays);
    sum += weights[static_cast<std::size_t>(leaf)];
  }
  float cumulative = 0.0f;
  for (int leaf = 0; leaf < leaves_; ++leaf) {
    const float guided = sum > 0.0f ? weights[static_cast<std::size_t>(leaf)] / sum : partition_.probability(leaf);
    cumulative += (1.0f - kPlainShare) * guided + kPlainShare * partition_.probability(leaf);
    cumulative_[at(cell, leaf)] = cumulative;
  }
}

}  // namespace maquette
