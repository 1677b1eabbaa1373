#pragma once

#include "render/environment/environment_tables.h"

namespace maquette {

/// Fills `bandwidth` and `seen_bandwidth` (and their size): nu_L per cell of a grid of at most 256 x 128, in cycles per
/// radian of direction.
///
/// Rows (longitude) and great circles through the poles (latitude) are transformed by Daubechies-4 wavelets; the
/// energies of a cell per level give, for each axis, the frequency above which 5 % of the local energy lies. The
/// stretching of rows by 1 / sin(theta) is corrected (up to a factor of 4); nu_L is the length of the two values.
/// Differs from a plain 95 % box of the spectrum: (1) the mean counts as no energy, and energy below 1 % of the local
/// mean is ignored, so that a fine pattern on a wall has its own bandwidth whatever its contrast, and a constant has
/// none; (2) light brighter than 64 times the brightest mean among the cell and its neighbours is clipped for this
/// cell: wavelets are wide, and the tail of a sun's coefficients would otherwise hide the sky's own detail everywhere.
///
/// A lobe convolves the light, so the spectrum of the reflected light is the product of both spectra. The 95 % point of
/// a product may lie far below those of its factors: an edge has the same energy in each octave, mostly in octaves that
/// the lobe does not attenuate. Therefore each cell's spectrum is multiplied by that of a Gaussian lobe of nu_rho, and
/// the quantile is taken of the product. Differs: the method takes min(nu_L, nu_rho), which is right where the light's
/// spectrum is flat or a single wave, and 1.2 to 2 times too high at edges.
///
/// Lower limit: what a Lambert lobe reflects, unless the light itself varies more slowly. The irradiance of skies has
/// nu of 0.2 to 0.5 cycles/rad, less than wavelets on a circle of 2 pi can resolve.
void compute_bandwidth(const Environment& environment, EnvironmentTables& tables);

}  // namespace maquette
