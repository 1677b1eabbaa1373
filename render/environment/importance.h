#pragma once

#include "render/environment/environment_tables.h"

namespace maquette {

/// Weights for the integral of the bilinear radiance over the cells of one row: texel rows y - 1, y, y + 1 are summed
/// with these weights, then columns with 1/8, 6/8, 1/8. In sr per texel, exact for bilinear reconstruction (clamped at
/// the poles).
struct RowWeights {
  double above = 0.0, here = 0.0, below = 0.0;
  double solid_angle() const { return above + here + below; }
};
RowWeights row_weights(int y, int width, int height);

/// Fills the CDFs, `density` and `luminance_integral` of the tables.
void compute_importance(const Environment& environment, EnvironmentTables& tables);

}  // namespace maquette
