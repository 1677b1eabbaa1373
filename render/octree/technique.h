#pragma once

#include "render/registry.h"

namespace maquette {

TechniqueInfo octree_technique();

}  // namespace maquette
