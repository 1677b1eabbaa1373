#pragma once

// shaders/shared/indirect.glsl compiled as C++: the same source as on the GPU.
#include "render/rgb9e5_shared.h"

namespace maquette::shared {
#include "shared/indirect.glsl"
}  // namespace maquette::shared
