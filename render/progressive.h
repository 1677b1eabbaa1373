#pragma once

#include <cstdint>

#include "render/gl/objects.h"

namespace maquette {

/// What mode `bandwidth` keeps of each grid point while nothing moves. Made only for pictures that accumulate.
struct Progressive {
  Texture mean;          ///< RGBA32F: mean of the point's work items, and their number
  Texture spread;        ///< R32F: sum of squared deviations of the items
  Texture deviation;     ///< R32F: measured deviation of one sample
  Buffer sums;           ///< vec4 a tile, as in the list of tiles (shaders/bandwidth/measure.comp)
  double items = 0.0;    ///< taken so far, all points
  double largest = 0.0;  ///< items of the point that has most of them, since the light samples were drawn

  static Progressive make(int grid_width, int grid_height, std::size_t tiles);
  void clear();
  std::size_t bytes() const { return mean.bytes() + spread.bytes() + deviation.bytes() + sums.bytes(); }
};

/// How measured deviations become work items in the next frame.
struct RefineRates {
  float items_per_deviation = 0.0f;
  float least_deviation = 0.0f;  ///< added everywhere, so that nothing the measurement missed starves
};

}  // namespace maquette
