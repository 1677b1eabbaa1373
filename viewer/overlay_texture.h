#pragma once

#include <imgui.h>

#include "render/gl/objects.h"
#include "scenes/image.h"

namespace maquette {

/// Texture of a display-encoded picture (0 to 1, RGBA), to be drawn over the window's.
Texture overlay_texture(const Image& display, const char* label, GLenum filter);
ImTextureID texture_id(const Texture& texture);

}  // namespace maquette
