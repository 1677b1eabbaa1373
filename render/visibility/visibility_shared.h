#pragma once

// shaders/shared/visibility.glsl compiled as C++: the same source as on the GPU.
#include "render/environment/directions_shared.h"

namespace maquette::shared {
#include "shared/visibility.glsl"
}  // namespace maquette::shared
