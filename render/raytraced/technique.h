#pragma once

#include "render/registry.h"

namespace maquette {

TechniqueInfo raytraced_technique();

}  // namespace maquette
