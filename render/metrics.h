#pragma once

#include <optional>

#include "scenes/image.h"

namespace maquette {

/// Error of a picture against a reference, over the pixels where the reference's alpha is 1 (all, without alpha) and
/// both are finite, over R, G, B. A figure is absent where it has no meaning (zero mean, no pixels).
struct ErrorFigures {
  std::optional<double> rmse;
  std::optional<double> relative_rmse;  ///< rmse over the mean luminance of the reference
  std::optional<double> psnr;           ///< dB, peak = largest value of the reference; absent for equal pictures
  std::optional<double>
      relmse;  ///< mean of (a - r)^2 / (r^2 + epsilon); Source: Rousselle et al. 2011, epsilon = 0.01 mean^2
  std::optional<double> flip;     ///< not measured yet: always absent
  std::size_t pixel_count = 0;    ///< pixels that were compared
  std::size_t invalid_count = 0;  ///< pixels left out because one of the pictures is NaN or infinite there
};

/// Throws Error when the sizes differ or a picture has fewer than 3 channels. Differs from Rousselle: their epsilon is
/// 0.01 in the units of their scenes; ours follows the mean luminance, so that the figure does not depend on the unit.
ErrorFigures compare_images(const Image& image, const Image& reference);

}  // namespace maquette
