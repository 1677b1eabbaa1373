#pragma once

#include <memory>

#include "render/shading/picture_mode.h"

namespace maquette {

/// The path tracer's picture as a frame.
std::unique_ptr<PictureMode> make_reference_mode();

}  // namespace maquette
