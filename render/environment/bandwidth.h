#pragma once

#include "render/environment/environment_tables.h"

namespace maquette {

/// Fills `bandwidth` (and its size): nu_L per cell of a grid of at most 256 x 128, in cycles per radian of direction.
///
/// Rows (longitude) and great circles through the poles (latitude) are transformed by Daubechies-4 wavelets; each
/// cell's level energies give the frequency above which 5 % of the local energy lies, per axis, sin(theta) of the rows
/// undone (at most 4 times); nu_L is the length of the two. Differs from a plain 95 % box of the spectrum: (1) the mean
/// counts as no energy, and a tail below 1 % of the local mean is nothing, so that a wall's fine pattern has its own
/// bandwidth whatever its contrast, and a constant none; (2) light above 64 times the brightest mean among the cell and
/// its neighbours is clipped for this cell: wavelets are wide, and the tail of a sun's coefficients would otherwise
/// bury the sky's own detail everywhere.
void compute_bandwidth(const Environment& environment, EnvironmentTables& tables);

}  // namespace maquette
