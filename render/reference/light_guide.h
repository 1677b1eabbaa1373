#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "render/environment/environment_tables.h"
#include "render/reference/hash_grid.h"

namespace maquette {

/// The environment map, divided into rectangles that are either small or dim. They are the strata that a guide chooses
/// from.
class EnvironmentPartition {
 public:
  static constexpr int kMostLeaves = 64;
  explicit EnvironmentPartition(const EnvironmentTables& tables);

  int leaf_count() const { return static_cast<int>(leaves_.size()); }
  /// Probability of the leaf under the importance of the tables.
  float probability(int leaf) const { return leaves_[static_cast<std::size_t>(leaf)].probability; }
  int leaf_at(int x, int y) const { return leaf_map_[static_cast<std::size_t>(y * width_ + x)]; }
  /// Samples a point within a leaf by importance. Where the leaf is chosen with `probability`, the density is
  /// EnvironmentTables::density.
  EnvironmentPoint sample(const EnvironmentTables& tables, int leaf, double u, double v) const;
  /// xyz: unit direction of the middle of a leaf, in the map's frame; w: largest distance (chord length) of any
  /// direction of the leaf from it.
  glm::vec4 axis_and_extent(int leaf) const;
  /// Sine of the latitude of a row's upper edge.
  double sine_above(std::size_t row) const { return row_sines_[row]; }
  /// Unit direction of a point, in the map's frame.
  glm::vec3 direction(const EnvironmentPoint& point) const;

 private:
  struct Leaf {
    int x0 = 0, y0 = 0, x1 = 0, y1 = 0;  ///< texels, ends exclusive
    float probability = 0.0f;
    std::vector<double> rows;  ///< [y1 - y0 + 1] cumulative
  };
  int width_ = 0;
  std::vector<double> row_sines_;  ///< [height + 1] sines of the latitudes of the rows' edges
  std::vector<Leaf> leaves_;
  std::vector<std::uint8_t> leaf_map_;  ///< [height][width]
};

/// Probabilities of the leaves at one surface: the visibility that its grid cell has learned, times the mean cosine
/// over each leaf.
struct LeafShares {
  static constexpr int kBlock = 8, kBlocks = EnvironmentPartition::kMostLeaves / kBlock;
  /// Leaf `l` is at [l % kBlock][l / kBlock]: the blocks are interleaved, so that prefix sums of all of them run in
  /// SIMD lanes.
  static constexpr std::size_t index_of(int leaf) {
    return static_cast<std::size_t>(leaf % kBlock * kBlocks + leaf / kBlock);
  }
  /// Sum of the leaves before this one in its block; one more row holds the sums of whole blocks.
  alignas(32) std::array<float, EnvironmentPartition::kMostLeaves + kBlocks> cumulative;
  alignas(32) std::array<float, kBlocks + 1> begins;  ///< first cumulative value of each block; the last: the total
  float sum() const { return begins[kBlocks]; }
  float probability(int leaf) const {
    const std::size_t at = index_of(leaf);
    return (cumulative[at + kBlocks] - cumulative[at]) / sum();
  }

  struct Choice {
    int leaf;
    float within;       ///< the random number, rescaled to [0, 1) within the leaf
    float probability;  ///< of the leaf
  };
  /// Selects a leaf by `u` in [0, 1). Compares with all entries, without branches that could be mispredicted.
  Choice choose_leaf(float u) const {
    float along = u * sum();
    int block = 0, row = 0;
    for (std::size_t b = 1; b < kBlocks; ++b) block += begins[b] <= along ? 1 : 0;
    along -= begins[static_cast<std::size_t>(block)];
    const float* sums = cumulative.data() + block;
    for (int i = 1; i < kBlock; ++i) row += sums[i * kBlocks] <= along ? 1 : 0;
    const float before = sums[row * kBlocks], width = sums[(row + 1) * kBlocks] - before;
    const int leaf = block * kBlock + row;
    if (!(width > 0.0f)) return last_with_light(leaf);
    const float within = (along - before) / width;
    return {leaf, within > 0.0f ? std::min(within, kLast) : 0.0f, width / sum()};
  }

 private:
  static constexpr float kLast = 0x1.fffffep-1f;  ///< below 1
  /// For sums that rounding has moved past the last leaf with light.
  Choice last_with_light(int leaf) const;
};

/// Learns, while a picture is traced, which parts of the environment light which parts of the scene. Shadow rays then
/// go to directions that a grid cell can see: in a car's cabin most of the sky is hidden from most surfaces.
///
/// For every grid cell and every leaf, the squared visibilities of the shadow rays so far are summed (as integers, so
/// that the order of the threads does not matter). Between passes, learn() turns the sums into probabilities. A tenth
/// follows the plain importance, so that every direction keeps a density. Estimates stay unbiased: a pass samples by
/// what earlier passes learned. Source: Vorba et al. 2014, "On-line Learning of Parametric Mixture Models for Light
/// Transport Simulation" (the idea); Bitterli 2015 and others tabulate visibility in this way.
class LightGuide {
 public:
  static constexpr std::uint32_t kNoCell = HashGrid::kNoCell;
  LightGuide(const EnvironmentPartition& partition, const HashGrid& grid);

  std::uint32_t cell_of(const glm::vec3& position, const glm::vec3& normal) const {
    return grid_.cell_of(position, normal);
  }
  /// Prefetches what compute_shares and openness read. Always inlined: GCC drops calls of a function that only
  /// prefetches, as without effect.
  [[gnu::always_inline]] void prefetch(std::uint32_t cell) const {
    const auto* shares = reinterpret_cast<const char*>(&shares_[cell]);
    for (std::size_t line = 0; line < sizeof(CellShares); line += 64) __builtin_prefetch(shares + line);
    __builtin_prefetch(&openness_[cell]);
  }
  /// Share of the environment's light that is known to reach a cell; 0 where nothing is known.
  float openness(std::uint32_t cell) const { return openness_[cell]; }
  /// Probabilities of the leaves for a surface of unit `normal` (in the map's frame).
  void compute_shares(std::uint32_t cell, const glm::vec3& normal, LeafShares* shares) const;
  /// Mean cosine over a leaf at a surface of unit `normal` (in the map's frame).
  float facing(int leaf, const glm::vec3& normal) const;
  /// Probability of the leaf over its probability under the plain importance.
  float gain(const LeafShares& shares, int leaf) const {
    return shares.probability(leaf) * inverse_plain_[static_cast<std::size_t>(leaf)];
  }
  /// The same where the leaf's probability is known.
  float gain(const LeafShares::Choice& choice) const {
    return choice.probability * inverse_plain_[static_cast<std::size_t>(choice.leaf)];
  }
  /// Whether records are still used: after some iterations the guide is good enough.
  bool learning() const { return iterations_ < kTrainingIterations; }
  /// Prefetches what record writes.
  [[gnu::always_inline]] void prefetch_record(std::uint32_t cell, int leaf) const {
    __builtin_prefetch(&records_[at(cell, leaf)], 1);
  }
  /// Records one shadow ray: `useful` is its transmittance, in [0, 1]. It leaves out the cosine; otherwise the
  /// directions that a training iteration happened to sample would be preferred when they are sampled again.
  /// Thread-safe.
  void record(std::uint32_t cell, int leaf, float useful);
  /// Updates the probabilities from the records. Not while others use the guide.
  void learn();

 private:
  static constexpr std::uint32_t kCells = HashGrid::kCells;
  static constexpr std::size_t kLeaves = EnvironmentPartition::kMostLeaves;
  static constexpr int kTrainingIterations = 10;  ///< three before the first path, the last one after 64 paths
  std::size_t at(std::uint32_t cell, int leaf) const {
    return static_cast<std::size_t>(cell) * kLeaves + LeafShares::index_of(leaf);
  }
  void learn_cell(std::uint32_t cell);

  const EnvironmentPartition& partition_;
  HashGrid grid_;
  int leaves_;
  int iterations_ = 0;
  /// [cell][leaf] number of rays in the lower half, sum of their squares in the upper half: one atomic addition updates
  /// both.
  std::vector<std::atomic<std::uint64_t>> records_;
  /// [leaf] at LeafShares::index_of, relative, 0 only for leaves without light. Whole cache lines.
  struct alignas(64) CellShares {
    std::array<std::uint16_t, kLeaves> units;
  };
  std::vector<CellShares> shares_;
  std::vector<float> openness_;  ///< [cell]
  struct Leaves {
    alignas(32) std::array<float, kLeaves> x, y, z, extent, slope;
  };
  static void add_up(const CellShares& known, const Leaves& axes, const glm::vec3& normal, LeafShares* shares);
  Leaves axes_{};                               ///< at LeafShares::index_of
  std::array<float, kLeaves> inverse_plain_{};  ///< [leaf] 0 where there is no light
};

}  // namespace maquette
