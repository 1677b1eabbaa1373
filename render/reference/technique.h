#pragma once

#include "render/registry.h"

namespace maquette {

TechniqueInfo reference_technique();

}  // namespace maquette
