#pragma once

#include "render/registry.h"

namespace maquette {

TechniqueInfo triangle_technique();

}  // namespace maquette
