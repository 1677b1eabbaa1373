#pragma once

#include "render/technique/technique.h"

namespace maquette {

Technique reference_technique();

}  // namespace maquette
