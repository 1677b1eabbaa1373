#pragma once

#include <glm/glm.hpp>

#ifndef MAQUETTE_FN
#define MAQUETTE_FN inline
#endif

namespace maquette::shared {
using namespace glm;
#include "shared/latlong.glsl"
#include "shared/octahedral.glsl"
}  // namespace maquette::shared
