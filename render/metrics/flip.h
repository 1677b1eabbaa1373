#pragma once

#include "scenes/image.h"

namespace maquette {

/// Pixels per degree of visual angle for the viewer of the papers: 0.7 m from a display 0.7 m wide with 3,840 pixels.
inline constexpr double kFlipPixelsPerDegree = 67.02064327658226;

/// LDR-FLIP: the difference that a person sees who alternates between two pictures. `image`, `reference`: linear
/// Rec.709 as displayed, clamped to [0, 1]; equal sizes, at least three channels, finite. Returns one channel in [0,
/// 1], 0 where the pictures are equal. Source: Andersson et al. 2020, "FLIP: A Difference Evaluator for Alternating
/// Images".
Image flip_ldr_map(const Image& image, const Image& reference, double pixels_per_degree = kFlipPixelsPerDegree);

/// Range of exposures in EV that HDR-FLIP uses for a reference.
struct FlipExposures {
  double start_ev = 0.0;
  double stop_ev = 0.0;
  int count = 2;
  bool black = false;  ///< no pixel has light: the exposures are undefined
};

/// From the exposure at which the brightest pixel is displayed at 0.85 to that of the median pixel. Source: Andersson
/// et al. 2021, "Visualizing Errors in Rendered High Dynamic Range Images", Section 3. Differs: the median of the
/// pixels with light, so that a picture that is more than half black has exposures too.
FlipExposures flip_exposures(const Image& reference);

/// HDR-FLIP: the largest LDR-FLIP over the exposures, per pixel. Radiance in any unit, finite. A black reference uses
/// the exposures of `image`; two black pictures have no difference. At most 48 exposures, spread over the range.
Image flip_hdr_map(const Image& image, const Image& reference, double pixels_per_degree = kFlipPixelsPerDegree);

}  // namespace maquette
