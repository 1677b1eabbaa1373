#pragma once

#include "scenes/scene.h"

namespace maquette {

/// World bounds of what the scene is about: of all visible meshes and patches but a few that reach many times farther
/// than all others, as a sky dome or a stray triangle. Decides the first view, speeds and the ground.
Bounds subject_bounds(const Scene& scene);

}  // namespace maquette
