#pragma once

#include "tests/benchmarks/stage.h"

namespace maquette::bench {

Figures measure_prt_curves(Stage& stage);

}  // namespace maquette::bench
