#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "render/lights/light_list.h"

namespace maquette {

/// A range of `LightGrid::lights`: a node is chosen first, then one of its lights by power.
struct LightNode {
  int first = 0, count = 0;
  float before = 0.0f, share = 0.0f;  ///< power of all lights before the range, and of the range itself; relative to
                                      ///< the total, in steps of 2^-24
};

/// Probabilities of the lights at a point. Lights are the leaves of a binary tree, split at the middle of the longest
/// axis. A grid over their bounding box has for each of its cells a cut through the tree, fine where lights are near
/// and coarse where they are far. The probability of a node of the cut is proportional to the light that it may cause
/// in the cell: 0 behind the lights. Within a node lights are chosen by power. A quarter of the probability is by power
/// among all lights that reach the cell.
///
/// Chosen by power alone, one of 4,096 triangles beside a surface was drawn once in 100,000 samples, with a weight of
/// 100,000. Sources: Shirley, Wang, Zimmerman 1996, "Monte Carlo Techniques for Direct Lighting Calculations", Sec. 5
/// (spatial subdivision by importance); Walter et al. 2005, "Lightcuts" (cuts); Conty Estevez, Kulla 2018, "Importance
/// Sampling of Many Lights with Adaptive Tree Splitting" (cones of normals).
struct LightGrid {
  static constexpr int kMaxNodes = 64;   ///< of a cut; a multiple of 4
  std::vector<LightRecord> lights;       ///< selection_pdf by power, cdf their running sum, steps of 2^-24
  std::vector<float> running_power;      ///< [light] its cdf, contiguous for searches
  std::vector<int> order;                ///< [light] its index in the source list
  std::vector<LightNode> nodes;          ///< of the tree
  glm::vec3 low{0.0f}, cell_size{1.0f};  ///< of the inner cells, m
  glm::ivec3 cells{1};                   ///< including an outer layer of unbounded cells
  int stride = 4;                        ///< entries a cell, a multiple of 4
  std::vector<float> cumulative;         ///< [cell z][y][x][stride], 1 beyond the cut's end
  std::vector<std::uint32_t> cut;        ///< [cell z][y][x][stride] node of each entry, the last one's beyond the end
  std::vector<float> lux;  ///< [cell] most illuminance by all lights together, on a surface that faces each
  std::vector<float> lux_of_triangles;  ///< [cell] of that, by triangles, which mirrors can show
};
LightGrid build_light_grid(const LightList& list);

/// Index of the cell that contains a point (m).
std::size_t light_cell(const LightGrid& grid, const glm::vec3& position);

/// Prefetches the row and the lux of a cell.
[[gnu::always_inline]] inline void prefetch_cell(const LightGrid& grid, std::size_t cell) {
  constexpr std::size_t kLine = 16;  // entries
  const std::size_t row = cell * static_cast<std::size_t>(grid.stride);
  __builtin_prefetch(&grid.lux[cell]);
  for (std::size_t k = 0; k < static_cast<std::size_t>(grid.stride); k += kLine) {
    __builtin_prefetch(&grid.cumulative[row + k]);
    __builtin_prefetch(&grid.cut[row + k]);
  }
}

/// A light of `grid.lights`, and the probability of choosing it.
struct LightPick {
  std::size_t index = 0;
  float probability = 0.0f;
};
/// Chooses a light as shaders/shading/lights.glsl does: a node by u in [0, 1), a light in it by `within` / 2^32. The
/// grid must have at least one light.
LightPick choose_light(const LightGrid& grid, std::size_t cell, float u, std::uint32_t within);
/// Probability with which choose_light gives light `index`.
float light_probability(const LightGrid& grid, std::size_t cell, std::size_t index);

}  // namespace maquette
