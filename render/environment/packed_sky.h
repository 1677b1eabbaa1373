#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/math/shared_formulas.h"
#include "scenes/environment.h"

namespace maquette {

/// An environment in the form that shaders read with one fetch: packed (shared/rgb9e5.glsl) at the nodes of a grid,
/// bilinear between them. The light of a direction is the mean of the four nodes around it with bilinear weights; a
/// lookup selects one of them at random by its weight. The closer the nodes, the smaller the variance of the selection.
/// Nodes at a half or a quarter of the texel spacing represent the same bilinear map, because the texel centres are
/// among them.
struct PackedSky {
  int columns = 0, spans = 0;  ///< node (x, y) lies at ((x + offset) / columns, (y + offset) / spans) of the map
  int last_row = 0;            ///< rows beyond repeat the outermost
  float offset = 0.5f;
  int bias = 0;
  std::vector<std::uint32_t> words;  ///< [last_row + 1][columns]

  /// Radiance of a node; up to one column or row outside the grid is allowed.
  glm::vec3 at(int column, int row) const {
    const int wrapped = column < 0 ? column + columns : column >= columns ? column - columns : column;
    const auto x = static_cast<std::size_t>(wrapped), y = static_cast<std::size_t>(std::clamp(row, 0, last_row));
    return shared::unpack_rgb9e5(words[y * static_cast<std::size_t>(columns) + x], bias);
  }
};
/// Bias of the shared exponent for which the brightest texel is just representable.
int packing_bias(const Environment& environment);
/// Nodes per texel width: 4, 2 or 1, the largest with at most `most` nodes in all.
int sky_refinement(const Environment& environment, std::size_t most);
PackedSky pack_sky(const Environment& environment, int bias, int refinement);

}  // namespace maquette
