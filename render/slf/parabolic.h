#pragma once

#include "scenes/shared_glsl.h"

namespace maquette::shared {
#include "shared/parabolic.glsl"
}  // namespace maquette::shared
