#include "render/visibility/visibility_sides.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <bitset>

#include "render/visibility/visibility_shared.h"

namespace maquette {

namespace {

constexpr int kSide = shared::kVisibilityCells, kCells = kSide * kSide;
static_assert(kVisibilityWords == shared::kVisibilityWords);
using Cells = std::bitset<kCells>;

std::size_t cell_number(const glm::ivec2& cell) { return static_cast<std::size_t>(cell.y * kSide + cell.x); }

struct Map {
  std::array<glm::vec3, kCells> direction;
  std::array<std::array<std::uint8_t, 8>, kCells> neighbours;  ///< nearest first
  std::array<std::array<std::uint8_t, kSide + 2>, kSide + 2> bordered;
  Map() {
    for (int y = -1; y <= kSide; ++y)
      for (int x = -1; x <= kSide; ++x)
        bordered[static_cast<std::size_t>(y + 1)][static_cast<std::size_t>(x + 1)] =
            static_cast<std::uint8_t>(cell_number(shared::visibility_wrap({x, y})));
    for (int b = 0; b < kCells; ++b)
      direction[static_cast<std::size_t>(b)] = shared::visibility_cell_direction({b % kSide, b / kSide});
    for (int b = 0; b < kCells; ++b) {
      const auto x = static_cast<std::size_t>(b % kSide), y = static_cast<std::size_t>(b / kSide);
      auto& around = neighbours[static_cast<std::size_t>(b)];
      for (std::size_t k = 0; k < 8; ++k) around[k] = bordered[y + (k + (k > 3)) / 3][x + (k + (k > 3)) % 3];
      const glm::vec3& middle = direction[static_cast<std::size_t>(b)];
      std::stable_sort(around.begin(), around.end(), [&](std::uint8_t i, std::uint8_t j) {
        return glm::dot(middle, direction[i]) > glm::dot(middle, direction[j]);
      });
    }
  }
};

/// Rows of cells below the horizon that are given values: normals between vertices lean from the vertices' own.
constexpr int kRowsBelow = 3;
constexpr float kRowHeight = 0.22f;  ///< cosine

/// `heights`: cosines between the cells' directions and the normal of the side at hand.
Cells extended(const Map& map, const Cells& open, const std::array<float, kCells>& heights) {
  Cells known, side;
  for (std::size_t b = 0; b < kCells; ++b) {
    known[b] = heights[b] > 0.0f;
    side[b] = known[b] && open[b];
  }
  for (int row = 1; row <= kRowsBelow; ++row) {
    const Cells above = known;  // not what this row was given: that would run along the horizon
    for (std::size_t b = 0; b < kCells; ++b) {
      if (known[b] || heights[b] < -kRowHeight * static_cast<float>(row)) continue;
      for (const std::uint8_t n : map.neighbours[b]) {
        if (!above[n]) continue;
        known[b] = true;
        side[b] = side[n];
        break;
      }
    }
  }
  return side;
}

std::array<std::uint32_t, kVisibilityWords> packed(const Map& map, const Cells& cells) {
  std::array<std::uint32_t, kSide + 2> rows{};
  for (std::size_t y = 0; y < rows.size(); ++y)
    for (std::size_t x = 0; x < rows.size(); ++x) rows[y] |= static_cast<std::uint32_t>(cells[map.bordered[y][x]]) << x;
  std::array<std::uint32_t, kVisibilityWords> words{};
  for (std::size_t w = 0; w < kVisibilityWords; ++w)
    for (std::size_t y = 0; y < 4 && 3 * (w / 3) + y < rows.size(); ++y)
      words[w] |= ((rows[3 * (w / 3) + y] >> (7 * (w % 3))) & 255u) << (8 * y);
  return words;
}

}  // namespace

std::vector<VisibilitySides> visibility_sides(const std::vector<VisibilityBits>& bits,
                                              const std::vector<glm::vec3>& normals) {
  static const Map map;
  std::vector<VisibilitySides> sides(bits.size());
  tbb::parallel_for(tbb::blocked_range<std::size_t>(0, bits.size(), 1024),
                    [&](const tbb::blocked_range<std::size_t>& range) {
                      for (std::size_t v = range.begin(); v < range.end(); ++v) {
                        Cells open;
                        std::array<float, kCells> front, back;
                        for (std::size_t b = 0; b < kCells; ++b) {
                          open[b] = (bits[v][b >> 5] >> (b & 31u)) & 1u;
                          front[b] = glm::dot(normals[v], map.direction[b]);
                          back[b] = -front[b];
                        }
                        sides[v] = {packed(map, extended(map, open, front)), packed(map, extended(map, open, back))};
                      }
                    });
  return sides;
}

}  // namespace maquette
