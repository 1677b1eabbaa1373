#pragma once

#include "render/registry.h"

namespace maquette {

TechniqueInfo splitsum_technique();

}  // namespace maquette
