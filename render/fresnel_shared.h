#pragma once

// shaders/shared/fresnel.glsl and pane.glsl as C++: the very lines that the GPU compiles.
#include <glm/glm.hpp>

#ifndef MAQUETTE_FN
#define MAQUETTE_FN inline
#endif

namespace maquette::shared {
using namespace glm;
#include "shared/fresnel.glsl"
#include "shared/pane.glsl"
}  // namespace maquette::shared
