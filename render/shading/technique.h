#pragma once

#include "render/technique/technique.h"

namespace maquette {

Technique shading_technique();

}  // namespace maquette
