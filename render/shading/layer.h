#pragma once

#include "render/shading/shading_mode.h"

namespace maquette {

/// A layer of the frame at hand, and the mode that shades it.
struct DrawnLayer {
  LayerContext context;
  ShadingMode& mode;
};

}  // namespace maquette
