#pragma once

#include "scenes/image.h"

namespace maquette {

/// Structural similarity of the luma of two display-encoded pictures (0 to 1, at least three channels, equal sizes,
/// finite): one channel, 1 where they are equal. Gaussian window of 11 x 11 pixels, sigma 1.5, K1 = 0.01, K2 = 0.03,
/// dynamic range 1. Source: Wang et al. 2004, Eq. 13. Differs: border pixels are repeated outwards, so that the map has
/// the pictures' size.
Image ssim_map(const Image& image, const Image& reference);

}  // namespace maquette
