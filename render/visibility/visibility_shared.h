#pragma once

// shaders/shared/visibility.glsl as C++: the very lines that the GPU compiles.
#include "render/environment/directions_shared.h"

namespace maquette::shared {
#include "shared/visibility.glsl"
}  // namespace maquette::shared
