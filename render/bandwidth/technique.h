#pragma once

#include "render/technique/technique.h"

namespace maquette {

Technique bandwidth_technique();

}  // namespace maquette
