#pragma once

#include <cstdint>
#include <vector>

#include "render/frame_targets.h"
#include "render/gl/objects.h"

namespace maquette {

/// What mode `bandwidth` keeps of each grid point while nothing moves. Made only for pictures that accumulate.
struct Progressive {
  Texture mean;         ///< RGBA32F: mean of the point's work items, and their number
  Texture spread;       ///< R32F: sum of squared deviations of the items
  Texture deviation;    ///< R32F: measured deviation of one sample
  Texture residual;     ///< R32F: squared distance of own mean and what was interpolated there; -1 for none
  Texture residuals;    ///< RGBA32F: its sums [layer][tile] (shaders/bandwidth/measure.comp)
  Texture worth;        ///< RG32F: what interpolation is worth [layer][tile] (shaders/shared/interpolation.glsl)
  Buffer sums;          ///< two vec4 a tile, as in the list of tiles
  int levels = 0;       ///< that are interpolated
  double rate = 0.0;    ///< items per deviation of the frame before; 0 for none
  double rounds = 0.0;  ///< of the list of light samples, by the typical point

  static Progressive make(const FrameTargets& targets, int levels);
  void clear();
  /// By layer: the median over the tiles that were measured.
  std::vector<float> typical_kappas() const;
  std::size_t bytes() const {
    return mean.bytes() + spread.bytes() + deviation.bytes() + residual.bytes() + residuals.bytes() + worth.bytes() +
           sums.bytes();
  }
};

/// How measured deviations become work items in the next frame.
struct RefineRates {
  float items_per_deviation = 0.0f;
  float least_deviation = 0.0f;  ///< added everywhere, so that nothing the measurement missed starves
  unsigned most_items = 0;       ///< of either list, should the rate have been too bold
  double light_rounds = 0.0;     ///< how often the typical point has come round the list of light samples
};

}  // namespace maquette
