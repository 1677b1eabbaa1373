#pragma once

#include "scenes/environment.h"
#include "scenes/image.h"

namespace maquette {

/// Exposure in EV (the picture is multiplied by 2^EV) at which a scene lit by `environment` looks right at once: an 18
/// % grey that faces the light lands at the linear display value 0.2, unless the sky's log-average would then burn out
/// (above 0.65). 0 for a black environment; within [-40, 40]. An env_scale adds -log2(scale). Milliseconds.
float suggest_exposure_ev(const Environment& environment);

/// Over the sphere, in stored units. Milliseconds.
double mean_luminance(const Environment& environment);

/// `environment_ev` (of suggest_exposure_ev), raised by up to 2 stops where the surfaces of a picture are dark: a cabin
/// seen from inside gets a fraction of the daylight. Meters the log-average of the surfaces (alpha 1) to a display
/// value of 0.1; lights and sky count little. Lowered where that average is above 0.3: lamps outshine the environment.
float meter_exposure_ev(const Image& radiance, float environment_ev);

/// Index of a name for `curve` of shaders/shared/tonemap.glsl. Throws UsageError naming all.
int tonemap_index(const std::string& name);

}  // namespace maquette
