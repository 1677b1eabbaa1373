#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "render/lights/light_list.h"

namespace maquette {

/// Neighbours in `LightGrid::lights`, drawn as one: first one of them, then, by power, which.
struct LightNode {
  int first = 0, count = 0;
  float before = 0.0f, share = 0.0f;  ///< power of all lights before them, and their own; of 1, in steps of 2^-24
};

/// Which light a point looks at. Lights are the leaves of a binary tree, split at the middle of the longest axis; a
/// grid over their box has for each of its cells a cut through it, fine where lights are near and coarse where they are
/// far, and says how likely each node of that cut is, in proportion to the light that it may bring there: nothing from
/// behind. In a node lights are chosen by power. A quarter of the choice is by power among all that shine there.
///
/// Chosen by power alone, one of 4,096 triangles beside a surface was drawn once in 100,000 samples and brought 100,000
/// times the truth then. Sources: Shirley, Wang, Zimmerman 1996, "Monte Carlo Techniques for Direct Lighting
/// Calculations", Sec. 5 (spatial subdivision by importance); Walter et al. 2005, "Lightcuts" (cuts); Conty Estevez,
/// Kulla 2018, "Importance Sampling of Many Lights with Adaptive Tree Splitting" (cones of normals).
struct LightGrid {
  static constexpr int kMaxNodes = 64;   ///< of a cut; a multiple of 4
  std::vector<LightRecord> lights;       ///< selection_pdf by power, cdf their running sum, steps of 2^-24
  std::vector<float> running_power;      ///< [light] its cdf, close together for those who search
  std::vector<int> order;                ///< [light] its place in the list that the grid was made from
  std::vector<LightNode> nodes;          ///< of the tree
  glm::vec3 low{0.0f}, cell_size{1.0f};  ///< of the inner cells, m
  glm::ivec3 cells{1};                   ///< with one layer around that goes on for ever
  int stride = 4;                        ///< entries a cell, a multiple of 4
  std::vector<float> cumulative;         ///< [cell z][y][x][stride], 1 beyond the cut's end
  std::vector<std::uint32_t> cut;        ///< [cell z][y][x][stride] node of each entry, the last one's beyond the end
  std::vector<float> lux;  ///< [cell] what all lights together may bring there, to a surface that faces each
  std::vector<float> lux_of_triangles;  ///< [cell] of that, what can be seen in a mirror
};
LightGrid build_light_grid(const LightList& list);

/// The cell that holds a point, in m.
std::size_t light_cell(const LightGrid& grid, const glm::vec3& position);

/// Fetches what choosing in a cell and its lux read, ahead of time.
[[gnu::always_inline]] inline void prefetch_cell(const LightGrid& grid, std::size_t cell) {
  constexpr std::size_t kLine = 16;  // entries
  const std::size_t row = cell * static_cast<std::size_t>(grid.stride);
  __builtin_prefetch(&grid.lux[cell]);
  for (std::size_t k = 0; k < static_cast<std::size_t>(grid.stride); k += kLine) {
    __builtin_prefetch(&grid.cumulative[row + k]);
    __builtin_prefetch(&grid.cut[row + k]);
  }
}

/// A light of `grid.lights`, and the probability with which the point is given it.
struct LightPick {
  std::size_t index = 0;
  float probability = 0.0f;
};
/// One of at least one light, as shaders/shading/lights.glsl chooses it: a node by u in [0, 1), a light in it by
/// `place` of 2^32.
LightPick choose_light(const LightGrid& grid, std::size_t cell, float u, std::uint32_t place);
/// Probability with which choose_light gives light `index`.
float light_probability(const LightGrid& grid, std::size_t cell, std::size_t index);

}  // namespace maquette
