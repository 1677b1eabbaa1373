#pragma once

#include "render/environment/environment_tables.h"

namespace maquette {

/// Fills `bandwidth` and `seen_bandwidth` (and their size): nu_L per cell of a grid of at most 256 x 128, in cycles per
/// radian of direction.
///
/// Rows (longitude) and great circles through the poles (latitude) are transformed by Daubechies-4 wavelets; each
/// cell's level energies give the frequency above which 5 % of the local energy lies, per axis, sin(theta) of the rows
/// undone (at most 4 times); nu_L is the length of the two. Differs from a plain 95 % box of the spectrum: (1) the mean
/// counts as no energy, and a tail below 1 % of the local mean is nothing, so that a wall's fine pattern has its own
/// bandwidth whatever its contrast, and a constant none; (2) light above 64 times the brightest mean among the cell and
/// its neighbours is clipped for this cell: wavelets are wide, and the tail of a sun's coefficients would otherwise
/// bury the sky's own detail everywhere.
///
/// A lobe convolves the light, so that the spectrum of what is seen is the product of both. Of a product the 95 % point
/// may lie far below those of its factors: an edge has the same energy in each octave, and most of it is in those that
/// the lobe leaves alone. So each cell's spectrum is multiplied by what a Gaussian lobe of nu_rho leaves, and the tail
/// is taken of that. Differs: the method takes min(nu_L, nu_rho), which is right where the light's spectrum is flat or
/// a wave, and 1.2 to 2 times too high at edges.
///
/// What is seen changes no slower than a Lambert lobe, if the light itself does not: irradiance of skies has nu of 0.2
/// to 0.5 cycles/rad, which is less than wavelets on a circle of 2 pi can tell apart.
void compute_bandwidth(const Environment& environment, EnvironmentTables& tables);

}  // namespace maquette
