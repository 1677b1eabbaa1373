#pragma once

// shaders/shared/bezier.glsl compiled as C++, once in float and once in double. The GPU compiles the same source.
#include "scenes/shared_glsl.h"

namespace maquette::bezier_float {
using namespace glm;
using Real = float;
#include "shared/bezier.glsl"
}  // namespace maquette::bezier_float

namespace maquette::bezier_double {
using Real = double;
using vec2 = glm::dvec2;
using vec3 = glm::dvec3;
using vec4 = glm::dvec4;
using glm::abs;
using glm::clamp;
using glm::cross;
using glm::dot;
using glm::length;
using glm::max;
using glm::min;
using glm::sqrt;
#include "shared/bezier.glsl"
}  // namespace maquette::bezier_double
