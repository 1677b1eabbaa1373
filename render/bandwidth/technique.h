#pragma once

#include "render/registry.h"

namespace maquette {

TechniqueInfo bandwidth_technique();

}  // namespace maquette
