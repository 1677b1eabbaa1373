#pragma once

#include "scenes/environment.h"

namespace maquette {

inline constexpr double kLeastSunElevationDeg = 3.0, kMostSunElevationDeg = 87.0;
/// Clear sky with the sun so many degrees up, between these two, above a light ground; 1024 x 512, cd/m2 (sun disc included, about 1e9 cd/m2).
/// Hash and warnings are left empty.
Environment make_clear_sky(double sun_elevation_deg = 40.0);
/// A car studio: strip lights overhead, soft boxes, a light floor that fades into a dark surround; 1024 x 512, cd/m2.
Environment make_studio();

}  // namespace maquette
