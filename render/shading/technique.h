#pragma once

#include "render/registry.h"

namespace maquette {

TechniqueInfo shading_technique();

}  // namespace maquette
