#pragma once

#include "render/technique/technique.h"

namespace maquette {

Technique raytraced_technique();

}  // namespace maquette
