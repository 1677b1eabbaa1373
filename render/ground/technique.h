#pragma once

#include "render/technique/technique.h"

namespace maquette {

/// Settings of the ground that is added to a scene without one (scenes/ground.h); whoever loads the scene adds it.
Technique ground_technique();

}  // namespace maquette
