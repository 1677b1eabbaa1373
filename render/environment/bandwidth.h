#pragma once

#include "render/environment/environment_tables.h"

namespace maquette {

/// Fills `bandwidth` (and its size): nu_L per cell of a grid of at most 256 x 128, in cycles per radian of direction.
///
/// Rows (longitude) and great circles through the poles (latitude) are transformed by Daubechies-4 wavelets; each
/// cell's level energies give the frequency above which 5 % of the local energy lies, per axis, sin(theta) of the rows
/// undone (at most 4 times); nu_L is the length of the two.
///
/// Two departures from a plain 95 % box of the spectrum. The mean counts as no energy, and a tail below 3 % of the local
/// mean is nothing: a wall's pattern has its own bandwidth whatever its contrast, and a constant none. And light above 4
/// times the brightest mean among the cell and its neighbours is clipped for this cell: wavelets are wide, and the tail
/// of a sun's or a window's coefficients would otherwise bury the detail of what is darker around it. The price: where a
/// slow, strong variation goes through darkness (a cosine's trough), the dark cells are over-estimated.
void compute_bandwidth(const Environment& environment, EnvironmentTables& tables);

}  // namespace maquette
