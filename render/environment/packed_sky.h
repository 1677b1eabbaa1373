#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "render/rgb9e5_shared.h"
#include "scenes/environment.h"

namespace maquette {

/// An environment as shaders read one texel of it: packed (shared/rgb9e5.glsl) at the nodes of a grid between which it
/// is bilinear. A direction's light is the mean of the four nodes around it by bilinear weights, and one of them,
/// chosen with its weight, stands for it: the closer the nodes, the less the choice matters. Nodes at every second or
/// fourth part of a texel hold the same bilinear map, since texels' centres are among them.
struct PackedSky {
  int columns = 0, spans = 0;  ///< node (x, y) lies at ((x + offset) / columns, (y + offset) / spans) of the map
  int last_row = 0;            ///< rows beyond are the outermost
  float offset = 0.5f;
  int bias = 0;
  std::vector<std::uint32_t> words;  ///< [last_row + 1][columns]

  /// Radiance of a node up to one column or row beyond the ends.
  glm::vec3 at(int column, int row) const {
    const int wrapped = column < 0 ? column + columns : column >= columns ? column - columns : column;
    const auto x = static_cast<std::size_t>(wrapped), y = static_cast<std::size_t>(std::clamp(row, 0, last_row));
    return shared::unpack_rgb9e5(words[y * static_cast<std::size_t>(columns) + x], bias);
  }
};
/// Bias of the shared exponent with which an environment is packed: its brightest texel just fits.
int packing_bias(const Environment& environment);
/// Nodes to a texel's width: 4, 2 or 1 (the texels themselves), the most with which there are no more than `most`.
int sky_refinement(const Environment& environment, std::size_t most);
PackedSky pack_sky(const Environment& environment, int bias, int refinement);

}  // namespace maquette
