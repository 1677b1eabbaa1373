#pragma once

// The formulas of shaders/shared as C++. Apart from these: luminance.glsl (scenes/luminance.h) and the files that want
// more than names: bezier.glsl (render/bezier/bezier_shared.h, in float and double), the octree's
// (render/octree/octree_shared.h, with what they walk), brdf_sampling.glsl, texture_filter.glsl and
// latlong_bilinear.glsl (members of what they read), and those of one user.
#include <glm/gtc/packing.hpp>
#include <glm/integer.hpp>

#include "scenes/luminance.h"
#include "scenes/shared_glsl.h"

namespace maquette::shared {
using Real = float;
// Some need others before them.
// clang-format off
#include "shared/constants.glsl"
#include "shared/latlong.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/interpolation.glsl"
#include "shared/bandwidth.glsl"
#include "shared/screen_curvature.glsl"
#include "shared/fresnel.glsl"
#include "shared/pane.glsl"
#include "shared/lights.glsl"
#include "shared/visibility.glsl"
#include "shared/indirect.glsl"
#include "shared/merl.glsl"
#include "shared/surface_geometry.glsl"
#include "shared/analytic.glsl"
// clang-format on
}  // namespace maquette::shared
