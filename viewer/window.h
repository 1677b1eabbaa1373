#pragma once

#include "viewer/options.h"

namespace maquette {

/// Opens the window on the options' scene and returns when it is closed: the exit code. With `options.screenshot` it
/// closes by itself after `options.frames` drawn frames and leaves a PNG of the whole window. Throws Error without a
/// display (naming `render`), below OpenGL 4.5, or when scene or environment cannot be read.
int run_window(const SceneOptions& options);

}  // namespace maquette
