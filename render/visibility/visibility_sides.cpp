#include "render/visibility/visibility_sides.h"

#include <algorithm>
#include <bit>
#include <cstring>
#include <numeric>

#include "render/math/low_discrepancy.h"
#include "render/math/shared_formulas.h"
#include "render/math/wide.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr int kSide = shared::kVisibilityCells, kCells = kSide * kSide;
static_assert(kVisibilityWords == shared::kVisibilityWords);
/// One bit per cell, four rows a word.
using Cells = std::array<std::uint64_t, kSide / 4>;
static_assert(kSide == 16 && sizeof(VisibilityBits) == sizeof(Cells));
/// Rows extended by the cells beyond their ends, which the folds of the map connect to; bit 0 is x = -1.
using Bordered = std::array<std::uint32_t, kSide + 2>;

constexpr int kNeighbours = 8;
/// Offset from a cell to its neighbour k.
constexpr glm::ivec2 step(int k) { return {(k + (k > 3)) % 3 - 1, (k + (k > 3)) / 3 - 1}; }

struct Map {
  std::array<float, kCells> x, y, z;  ///< directions of the cells
  /// [rank][k] cells for which neighbour k has this rank by distance.
  std::array<std::array<Cells, kNeighbours>, kNeighbours> ranked{};
  Map() {
    for (int b = 0; b < kCells; ++b) {
      const glm::ivec2 cell(b % kSide, b / kSide);
      const glm::vec3 middle = shared::visibility_cell_direction(cell);
      const auto i = static_cast<std::size_t>(b);
      x[i] = middle.x;
      y[i] = middle.y;
      z[i] = middle.z;
      std::array<std::size_t, kNeighbours> around;
      std::iota(around.begin(), around.end(), 0u);
      const auto nearness = [&](std::size_t k) {
        const glm::ivec2 other = shared::visibility_wrap(cell + step(static_cast<int>(k)));
        return glm::dot(middle, shared::visibility_cell_direction(other));
      };
      std::stable_sort(around.begin(), around.end(),
                       [&](std::size_t k, std::size_t l) { return nearness(k) > nearness(l); });
      for (std::size_t rank = 0; rank < kNeighbours; ++rank) ranked[rank][around[rank]][i / 64] |= 1ull << (i % 64);
    }
  }
};

Bordered bordered(const Cells& cells) {
  Bordered rows;
  const auto row = [&](std::size_t y) { return static_cast<std::uint32_t>(cells[y / 4] >> (16 * (y % 4))) & 0xffffu; };
  for (std::size_t y = 0; y < kSide; ++y) {
    // Beyond its ends a row continues in the opposite row, from the same end.
    const std::uint32_t opposite = row(kSide - 1 - y);
    rows[y + 1] = (opposite & 1u) | row(y) << 1 | (opposite >> (kSide - 1)) << (kSide + 1);
  }
  // The first and last row continue in themselves, reversed.
  const auto mirrored = [](std::uint32_t bits) { return reverse_bits(bits) >> (32 - (kSide + 2)); };
  rows[0] = mirrored(rows[1]);
  rows[kSide + 1] = mirrored(rows[kSide]);
  return rows;
}

/// The bits of each cell's neighbours.
struct Around {
  std::array<std::array<std::uint16_t, kSide + 2>, 3> columns;  ///< [x + 1][y + 1]
  explicit Around(const Cells& cells) {
    const Bordered rows = bordered(cells);
    for (std::size_t x = 0; x < 3; ++x)
      for (std::size_t y = 0; y < rows.size(); ++y) columns[x][y] = static_cast<std::uint16_t>(rows[y] >> x);
  }
  Cells neighbour(int k) const {
    const glm::ivec2 by = step(k);
    Cells result;
    std::memcpy(&result, &columns[static_cast<std::size_t>(by.x + 1)][static_cast<std::size_t>(by.y + 1)],
                sizeof result);
    return result;
  }
};
static_assert(std::endian::native == std::endian::little);

/// Rows of cells below the horizon that are filled in: normals between vertices lean away from those of the vertices.
constexpr int kRowsBelow = 3;
constexpr float kRowHeight = 0.22f;  ///< cosine

/// Cells whose cosine with the normal is above 0, then cells down to each of the rows below.
using Levels = std::array<Cells, kRowsBelow + 1>;

/// The levels of both sides of a plane, +n first.
MAQUETTE_WIDE void find_levels(const Map& map, float nx, float ny, float nz, std::array<Levels, 2>* out) {
  std::array<Levels, 2> sides{};  // local, so that the compiler knows that the loops do not write to their inputs
  for (std::size_t half = 0; half < 2 * std::tuple_size_v<Cells>; ++half) {
    std::array<float, 32> height;
    for (std::size_t i = 0; i < 32; ++i)
      height[i] = nx * map.x[32 * half + i] + ny * map.y[32 * half + i] + nz * map.z[32 * half + i];
    for (std::size_t row = 0; row <= kRowsBelow; ++row) {
      const float least = -kRowHeight * static_cast<float>(row);
      std::uint32_t front = 0, back = 0;
      for (std::uint32_t i = 0; i < 32; ++i) {
        // The horizon itself does not belong to the first level.
        const bool above = row > 0 ? height[i] >= least : height[i] > 0.0f;
        const bool below = row > 0 ? -height[i] >= least : height[i] < 0.0f;
        front |= above ? 1u << i : 0u;
        back |= below ? 1u << i : 0u;
      }
      sides[0][row][half / 2] |= std::uint64_t{front} << (32 * (half % 2));
      sides[1][row][half / 2] |= std::uint64_t{back} << (32 * (half % 2));
    }
  }
  *out = sides;
}

/// Fills cells below the horizon with the value of their nearest neighbour, row by row, all cells in parallel.
MAQUETTE_WIDE void extend(const Map& map, const Levels& levels, Cells* side) {
  constexpr std::size_t kWords = std::tuple_size_v<Cells>;
  Cells known = levels[0], held = *side;
  for (std::size_t row = 1; row <= kRowsBelow; ++row) {
    // Only values known before this row: otherwise values would spread along the horizon.
    const Around known_around(known), held_around(held);
    std::array<Cells, kNeighbours> known_there, held_there;
    for (int k = 0; k < kNeighbours; ++k) {
      known_there[static_cast<std::size_t>(k)] = known_around.neighbour(k);
      held_there[static_cast<std::size_t>(k)] = held_around.neighbour(k);
    }
    Cells asked;
    for (std::size_t w = 0; w < kWords; ++w) asked[w] = levels[row][w] & ~known[w];
    for (std::size_t rank = 0; rank < kNeighbours; ++rank) {
      Cells found{}, taken{};
      for (std::size_t k = 0; k < kNeighbours; ++k)
        for (std::size_t w = 0; w < kWords; ++w) {
          const std::uint64_t here = map.ranked[rank][k][w] & known_there[k][w];
          found[w] |= here;
          taken[w] |= here & held_there[k][w];
        }
      for (std::size_t w = 0; w < kWords; ++w) {
        held[w] |= taken[w] & asked[w];
        known[w] |= found[w] & asked[w];
        asked[w] &= ~found[w];
      }
    }
  }
  *side = held;
}

std::array<std::uint32_t, kVisibilityWords> packed(const Cells& cells) {
  const Bordered rows = bordered(cells);
  std::array<std::uint32_t, kVisibilityWords> words{};
  for (std::size_t w = 0; w < kVisibilityWords; ++w)
    for (std::size_t y = 0; y < 4 && 3 * (w / 3) + y < rows.size(); ++y)
      words[w] |= ((rows[3 * (w / 3) + y] >> (7 * (w % 3))) & 255u) << (8 * y);
  return words;
}

VisibilitySides sides_of(const Map& map, const VisibilityBits& bits, const glm::vec3& normal) {
  Cells open;
  std::memcpy(&open, &bits, sizeof open);
  std::array<Levels, 2> levels;
  find_levels(map, normal.x, normal.y, normal.z, &levels);
  VisibilitySides sides{};
  for (std::size_t s = 0; s < 2; ++s) {
    Cells side;
    for (std::size_t w = 0; w < side.size(); ++w) side[w] = open[w] & levels[s][0][w];
    if (side == Cells{}) continue;  // most sides in a closed body
    extend(map, levels[s], &side);
    sides[s] = packed(side);
  }
  return sides;
}

}  // namespace

std::vector<VisibilitySides> visibility_sides(const std::vector<VisibilityBits>& bits,
                                              const std::vector<glm::vec3>& normals) {
  static const Map map;
  std::vector<VisibilitySides> sides(bits.size());
  parallel_ranges<std::size_t>(0, bits.size(), 1024, [&](const auto& range) {
    for (std::size_t v = range.begin(); v < range.end(); ++v) sides[v] = sides_of(map, bits[v], normals[v]);
  });
  return sides;
}

}  // namespace maquette
