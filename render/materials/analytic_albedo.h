#pragma once

#include "render/math/shared_formulas.h"

namespace maquette::shared {
#include "shared/analytic_albedo.glsl"
}  // namespace maquette::shared
