#pragma once

#include "render/registry.h"

namespace maquette {

/// Settings that all reflector techniques share.
TechniqueInfo reflections_technique();

}  // namespace maquette
