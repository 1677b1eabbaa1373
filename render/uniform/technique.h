#pragma once

#include "render/technique/technique.h"

namespace maquette {

Technique uniform_technique();

}  // namespace maquette
