#pragma once

#include "tests/benchmarks/stage.h"

namespace maquette::bench {

Figures measure_prt_curves(Stage& stage);

/// relative_rmse over the pixels that the reference covers (alpha 1).
double error_of_covered(const Image& picture, const Image& reference);

}  // namespace maquette::bench
