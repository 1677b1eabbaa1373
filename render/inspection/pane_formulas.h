#pragma once

// What the renderer computes of panes, shaders/shared/fresnel.glsl and pane.glsl, compiled in double.
#include "scenes/shared_glsl.h"

namespace maquette::pane_double {
using Real = double;
using vec2 = glm::dvec2;
using vec3 = glm::dvec3;
using glm::clamp;
using glm::dot;
using glm::inversesqrt;
using glm::max;
using glm::sqrt;
#include "shared/fresnel.glsl"
#include "shared/pane.glsl"
}  // namespace maquette::pane_double
