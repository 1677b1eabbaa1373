#pragma once

#include "render/technique/technique.h"

namespace maquette {

Technique triangle_technique();

}  // namespace maquette
