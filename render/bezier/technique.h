#pragma once

#include "render/technique/technique.h"

namespace maquette {

Technique bezier_technique();

}  // namespace maquette
