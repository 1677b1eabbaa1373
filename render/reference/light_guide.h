#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "render/environment/environment_tables.h"
#include "render/reference/place_grid.h"

namespace maquette {

/// The environment's map cut into rectangles that are either small or dim: the lamps of a guide.
class EnvironmentPartition {
 public:
  static constexpr int kMostLeaves = 64;
  explicit EnvironmentPartition(const EnvironmentTables& tables);

  int leaf_count() const { return static_cast<int>(leaves_.size()); }
  /// Probability of the leaf under the tables' own importance.
  float probability(int leaf) const { return leaves_[static_cast<std::size_t>(leaf)].probability; }
  int leaf_at(int x, int y) const { return leaf_map_[static_cast<std::size_t>(y * width_ + x)]; }
  /// Point within a leaf, by importance: the density is EnvironmentTables::density where the leaf has its own
  /// probability.
  EnvironmentPoint sample(const EnvironmentTables& tables, int leaf, double u, double v) const;
  /// Unit direction of the middle of a leaf, in the map's frame, and how far any direction of the leaf is from it at
  /// most: the length of the chord.
  glm::vec4 axis_and_extent(int leaf) const;
  /// Of the latitude of a row's upper edge.
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
  std::vector<double> row_sines_;  ///< [height + 1] of the latitude of the rows' edges
  std::vector<Leaf> leaves_;
  std::vector<std::uint8_t> leaf_map_;  ///< [height][width]
};

/// Probabilities of the leaves at one surface: what its place is known to see, times how far each leaf stands above the
/// surface's horizon.
struct LeafShares {
  static constexpr int kBlock = 8, kBlocks = EnvironmentPartition::kMostLeaves / kBlock;
  /// Leaf `l` is at [l % kBlock][l / kBlock]: blocks beside each other, so that sums run along all of them at once.
  static constexpr std::size_t place_of(int leaf) {
    return static_cast<std::size_t>(leaf % kBlock * kBlocks + leaf / kBlock);
  }
  /// Of the leaves before this one in its block; a row more for the sums of whole blocks.
  alignas(32) std::array<float, EnvironmentPartition::kMostLeaves + kBlocks> cumulative;
  alignas(32) std::array<float, kBlocks + 1> begins;  ///< of the blocks; the last: the sum of all
  float sum() const { return begins[kBlocks]; }
  float probability(int leaf) const {
    const std::size_t at = place_of(leaf);
    return (cumulative[at + kBlocks] - cumulative[at]) / sum();
  }

  struct Choice {
    int leaf;
    float within;       ///< the number, stretched over the leaf again, in [0, 1)
    float probability;  ///< of the leaf
  };
  /// `u` in [0, 1) picks the leaf. All are compared, and what is before the first is 0: no jump to guess wrong.
  Choice choose(float u) const {
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
  /// Rounded past it.
  Choice last_with_light(int leaf) const;
};

/// Learns while a picture is traced which parts of the environment light which parts of the scene, so that shadow rays
/// are spent on what a place can see: in a cabin most of the sky cannot be seen from most places.
///
/// For every cell of the places and every leaf the squares of the visibility of the shadow rays so far are
/// summed (whole numbers: the order in which threads add does not matter). Between passes, learn() turns them into
/// probabilities; a tenth stays with the plain importance, so that every direction keeps a density. Estimates stay
/// unbiased: a pass draws with what passes before it learned. Source: Vorba et al. 2014, "On-line Learning of
/// Parametric Mixture Models for Light Transport Simulation" (the idea); Bitterli 2015 and others tabulate visibility
/// so.
class LightGuide {
 public:
  static constexpr std::uint32_t kNoCell = PlaceGrid::kNoCell;
  LightGuide(const EnvironmentPartition& partition, const PlaceGrid& grid);

  std::uint32_t cell_of(const glm::vec3& position, const glm::vec3& normal) const {
    return grid_.cell_of(position, normal);
  }
  /// Fetches what look and openness read, ahead of time. In line at once: of a function that does nothing but fetch GCC
  /// drops the calls, as without effect.
  [[gnu::always_inline]] void prefetch(std::uint32_t cell) const {
    const auto* shares = reinterpret_cast<const char*>(&shares_[cell]);
    for (std::size_t line = 0; line < sizeof(CellShares); line += 64) __builtin_prefetch(shares + line);
    __builtin_prefetch(&openness_[cell]);
  }
  /// Share of the environment's light that is known to reach a cell; 0 where nothing is known.
  float openness(std::uint32_t cell) const { return openness_[cell]; }
  /// What a surface of unit `normal` (in the map's frame) draws by.
  void look(std::uint32_t cell, const glm::vec3& normal, LeafShares* shares) const;
  /// Mean cosine over a leaf at a surface of unit `normal` (in the map's frame).
  float facing(int leaf, const glm::vec3& normal) const;
  /// Probability of the leaf over its plain one.
  float gain(const LeafShares& shares, int leaf) const {
    return shares.probability(leaf) * inverse_plain_[static_cast<std::size_t>(leaf)];
  }
  /// The same where the leaf's probability is known.
  float gain(const LeafShares::Choice& choice) const {
    return choice.probability * inverse_plain_[static_cast<std::size_t>(choice.leaf)];
  }
  /// Whether records still matter: places have seen enough after some passes.
  bool learning() const { return lessons_ < kLessons; }
  /// Fetches what record writes, ahead of time.
  [[gnu::always_inline]] void prefetch_record(std::uint32_t cell, int leaf) const {
    __builtin_prefetch(&records_[at(cell, leaf)], 1);
  }
  /// One shadow ray: `useful` is its transmittance, in [0, 1]. Not its cosine: the directions that a lesson saw would
  /// be preferred where they are drawn again. Thread-safe.
  void record(std::uint32_t cell, int leaf, float useful);
  /// Takes what was recorded into the probabilities. Not while others use the guide.
  void learn();

 private:
  static constexpr std::uint32_t kCells = PlaceGrid::kCells;
  static constexpr std::size_t kLeaves = EnvironmentPartition::kMostLeaves;
  static constexpr int kLessons = 10;  ///< three before the first path, the last one after 64 paths
  std::size_t at(std::uint32_t cell, int leaf) const {
    return static_cast<std::size_t>(cell) * kLeaves + LeafShares::place_of(leaf);
  }
  void learn_cell(std::uint32_t cell);

  const EnvironmentPartition& partition_;
  PlaceGrid grid_;
  int leaves_;
  int lessons_ = 0;
  /// [cell][leaf] rays in the lower half, what they were good for in the upper one: one addition for both.
  std::vector<std::atomic<std::uint64_t>> records_;
  /// [leaf] at LeafShares::place_of, relative, 0 only for leaves without light. Whole lines of memory.
  struct alignas(64) CellShares {
    std::array<std::uint16_t, kLeaves> units;
  };
  std::vector<CellShares> shares_;
  std::vector<float> openness_;  ///< [cell]
  struct Leaves {
    alignas(32) std::array<float, kLeaves> x, y, z, extent, slope;
  };
  static void add_up(const CellShares& known, const Leaves& axes, const glm::vec3& normal, LeafShares* shares);
  Leaves axes_{};                               ///< at LeafShares::place_of
  std::array<float, kLeaves> inverse_plain_{};  ///< [leaf] 0 where there is no light
};

}  // namespace maquette
