#pragma once

// shaders/shared/indirect.glsl as C++: the very lines that the GPU compiles.
#include "render/rgb9e5_shared.h"

namespace maquette::shared {
#include "shared/indirect.glsl"
}  // namespace maquette::shared
