#pragma once

#include "render/environment/environment_tables.h"

namespace maquette {

/// Integral of the bilinear radiance over each texel's cell, for one row: sums texel rows y - 1, y, y + 1 with these
/// weights, then columns with 1/8, 6/8, 1/8. Weights are sr per texel and exact for the bilinear reconstruction (poles
/// clamp).
struct RowWeights {
  double above = 0.0, here = 0.0, below = 0.0;
  double solid_angle() const { return above + here + below; }
};
RowWeights row_weights(int y, int width, int height);

/// Fills the CDFs, `density` and `luminance_integral` of the tables.
void compute_importance(const Environment& environment, EnvironmentTables& tables);

}  // namespace maquette
