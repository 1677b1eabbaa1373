#pragma once

// Formulas of shaders/shared of surfaces that few need, besides those of shared_formulas.h.
#include "render/math/shared_formulas.h"

namespace maquette::shared {
#include "shared/pane_faces.glsl"
#include "shared/triangle_tangent.glsl"
}  // namespace maquette::shared
