#pragma once

#include <optional>

#include "scenes/image.h"

namespace maquette {

/// The values at the two ends of the colour scale.
struct FalseColorRange {
  float low = 0.0f;
  float high = 1.0f;
};

/// Range of the finite values of `channel`: from 0 (or the lowest negative value) to the 99.5th percentile, so that
/// single bright pixels do not flatten the picture; [0, 1] when there are no values.
FalseColorRange false_color_range(const Image& values, int channel = 0);

/// Channel `channel` of `values` as display-encoded RGBA (turbo); NaN and infinity magenta. `range` by default is
/// false_color_range. Alpha is that of a 4-channel image, otherwise 1.
Image false_color_image(const Image& values, std::optional<FalseColorRange> range = {}, int channel = 0);

/// A vertical scale for legends, high values at the top.
Image false_color_legend(int width, int height);

}  // namespace maquette
