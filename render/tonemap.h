#pragma once

#include "scenes/environment.h"

namespace maquette {

/// Exposure in EV (the picture is multiplied by 2^EV) at which a scene lit by `environment` looks right at once: an 18
/// % grey that faces the light lands at the linear display value 0.2, unless the sky's log-average would then burn out
/// (above 0.65). 0 for a black environment; within [-40, 40]. An env_scale adds -log2(scale). Milliseconds.
float suggest_exposure_ev(const Environment& environment);

/// Index of a name for `curve` of shaders/shared/tonemap.glsl. Throws UsageError naming all.
int tonemap_index(const std::string& name);

}  // namespace maquette
