#pragma once

// shaders/shared/interpolation.glsl as C++: the very lines that the GPU compiles.
#include <glm/glm.hpp>
#include <glm/integer.hpp>

#ifndef MAQUETTE_FN
#define MAQUETTE_FN inline
#endif

namespace maquette::shared {
using namespace glm;
#include "shared/interpolation.glsl"
}  // namespace maquette::shared
