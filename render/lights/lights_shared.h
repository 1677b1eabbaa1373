#pragma once

// shaders/shared/lights.glsl as C++: the same source that the GPU compiles.
#include <glm/glm.hpp>

#ifndef MAQUETTE_FN
#define MAQUETTE_FN inline
#endif

namespace maquette::shared {
using namespace glm;
#include "shared/lights.glsl"
}  // namespace maquette::shared
