#pragma once

namespace maquette {

#include "shared/bindings.glsl"

}  // namespace maquette
