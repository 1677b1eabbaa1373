#pragma once

#include "render/registry.h"

namespace maquette {

TechniqueInfo bezier_technique();

}  // namespace maquette
