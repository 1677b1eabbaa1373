#pragma once

#include <string>
#include <vector>

#include "scenes/environment.h"
#include "scenes/image.h"

namespace maquette {

/// `linear`, `reinhard`, `aces`, `agx`, `pbr-neutral`. Exposure first, then the curve, then the mean over the
/// `side` x `side` points of each pixel, then sRGB. Same formulas as the shader.
Image tone_map(const Image& points, float exposure_ev, const std::string& tonemap, int side = 1);
const std::vector<std::string>& tonemap_names();

/// Suggested exposure in EV (the picture is multiplied by 2^EV) for a scene lit by `environment`: an 18 % grey that
/// faces the light is displayed at the linear value 0.2, unless the sky's log-average would then be overexposed (above
/// 0.65). 0 for a black environment; within [-40, 40]. An env_scale adds -log2(scale). Takes milliseconds.
float suggest_exposure_ev(const Environment& environment);

/// Mean over the sphere, in stored units. Takes milliseconds.
double mean_luminance(const Environment& environment);

/// Adjusts `environment_ev` (of suggest_exposure_ev) to the picture: raised by up to 5 stops where the surfaces are
/// dark (a cabin seen from inside gets a fraction of the daylight). Meters the log-average of the surfaces (alpha 1),
/// with weight to the middle of the picture, to a display value of 0.1; lights count little, and the sky may clip.
/// Lowered where that average is above 0.3, because lamps are brighter than the environment.
float meter_exposure_ev(const Image& radiance, float environment_ev);

/// Index of a name for `curve` of shaders/shared/tonemap.glsl. Throws UsageError that lists all names.
int tonemap_index(const std::string& name);

}  // namespace maquette
