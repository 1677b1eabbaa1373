#pragma once

#include "scenes/image.h"

namespace maquette {

/// Pixels a degree of visual angle of the papers' viewer: 0.7 m from a display 0.7 m wide with 3,840 pixels.
inline constexpr double kFlipPixelsPerDegree = 67.02064327658226;

/// LDR-FLIP: what a person sees who alternates between two pictures at the same place. `image`, `reference`: linear
/// Rec.709 as the display shows it, clamped to [0, 1]; equal sizes, at least three channels, finite. Returns one
/// channel in [0, 1], 0 where the pictures are equal. Source: Andersson et al. 2020, "FLIP: A Difference Evaluator for
/// Alternating Images".
Image flip_ldr_map(const Image& image, const Image& reference, double pixels_per_degree = kFlipPixelsPerDegree);

/// Exposures in EV between which HDR-FLIP looks at a reference.
struct FlipExposures {
  double start_ev = 0.0;
  double stop_ev = 0.0;
  int count = 2;
  bool black = false;  ///< no pixel has light: the exposures mean nothing
};

/// From the exposure at which the brightest pixel is shown at 0.85 to the one at which the median pixel is. Source:
/// Andersson et al. 2021, "Visualizing Errors in Rendered High Dynamic Range Images", Section 3. Differs: the median is
/// that of the pixels with light, so that a picture that is black for more than its half has exposures too.
FlipExposures flip_exposures(const Image& reference);

/// HDR-FLIP: the largest LDR-FLIP over the exposures, at every pixel. Radiance in any unit, finite. A black reference
/// takes the exposures of `image`; two black pictures differ nowhere. Exposures beyond 48 are spread over the range.
Image flip_hdr_map(const Image& image, const Image& reference, double pixels_per_degree = kFlipPixelsPerDegree);

}  // namespace maquette
