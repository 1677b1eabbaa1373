#pragma once

#include "render/registry.h"

namespace maquette {

TechniqueInfo uniform_technique();

}  // namespace maquette
