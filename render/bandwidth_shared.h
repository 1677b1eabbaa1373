#pragma once

// shaders/shared/bandwidth.glsl and screen_bend.glsl as C++: the very lines that the GPU compiles.
#include <glm/glm.hpp>
#include <glm/gtc/packing.hpp>

#ifndef MAQUETTE_FN
#define MAQUETTE_FN inline
#endif

namespace maquette::shared {
using namespace glm;
#include "shared/bandwidth.glsl"
// after the operators
#include "shared/screen_bend.glsl"
}  // namespace maquette::shared
