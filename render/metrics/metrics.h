#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "scenes/image.h"

namespace maquette {

/// Error of a picture against a reference, over R, G and B of the pixels where the reference's alpha is 1 (all, without
/// alpha) and both are finite. A figure is absent where it is undefined (zero mean, no pixels); `notes` say why.
struct ErrorFigures {
  std::optional<double> rmse;
  std::optional<double> relative_rmse;  ///< rmse over the mean luminance of the reference
  std::optional<double> psnr;           ///< dB, peak = largest value of the reference; absent for equal pictures
  std::optional<double>
      relmse;  ///< mean of (a - r)^2 / (r^2 + epsilon); Source: Rousselle et al. 2011, epsilon = 0.01 mean^2
  std::optional<double> flip;           ///< mean of HDR-FLIP (render/metrics/flip.h), 0 to 1
  std::optional<double> flip_ldr;       ///< mean of LDR-FLIP of both as shown at `display_ev`
  std::optional<double> ssim;           ///< mean SSIM of both as shown at `display_ev`; 1 for equal pictures
  std::optional<double> display_ev;     ///< exposure of the two figures above
  std::size_t pixel_count = 0;          ///< compared pixels
  std::size_t invalid_count = 0;        ///< pixels left out because one of the pictures is NaN or infinite there
  std::vector<std::string> notes = {};  ///< why a figure is absent or was taken over fewer pixels, one line each
};

/// Only rmse, relative_rmse, psnr and relmse, in one pass over the pixels. Throws Error when the sizes differ or a
/// picture has fewer than 3 channels. Differs from Rousselle: their epsilon is 0.01 in the units of their scenes; ours
/// is relative to the mean luminance, so that the figure does not depend on the unit.
ErrorFigures compare_images(const Image& image, const Image& reference);

/// All figures and the error at every pixel.
struct ErrorReport {
  ErrorFigures figures;
  Image flip_map;  ///< HDR-FLIP, one channel; 0 where nothing was compared
};
/// As compare_images, with all figures; about 0.1 s for 640 x 360 pixels on one core, more for a wide range of
/// luminances.
ErrorReport measure_error(const Image& image, const Image& reference);

/// Exposure in EV at which the log-average luminance of the pixels with light (and alpha 1) is displayed as 0.18; 0 for
/// a black picture. Source: Reinhard et al. 2002, Eqs. 1 and 2.
double display_exposure_ev(const Image& reference);

/// HDR-FLIP in false colours from 0 to 1, NaN pixels magenta; alpha of the reference.
Image difference_picture(const ErrorReport& report, const Image& image, const Image& reference);

}  // namespace maquette
