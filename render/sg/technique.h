#pragma once

#include "render/registry.h"

namespace maquette {

TechniqueInfo sg_technique();

}  // namespace maquette
