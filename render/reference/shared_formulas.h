#pragma once

// The shaders' formulas as C++ for the path tracer: the same source that the GPU compiles.
#include <glm/glm.hpp>

#ifndef MAQUETTE_FN
#define MAQUETTE_FN inline
#endif

#include "render/environment/directions_shared.h"
#include "render/fresnel_shared.h"
#include "render/lights/lights_shared.h"
#include "render/materials/brdf_sampler.h"

namespace maquette::shared {
#include "shared/constants.glsl"
// after the constants
#include "shared/analytic.glsl"
#include "shared/surface_geometry.glsl"
}  // namespace maquette::shared
