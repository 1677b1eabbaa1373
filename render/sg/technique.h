#pragma once

#include "render/technique/technique.h"

namespace maquette {

Technique sg_technique();

}  // namespace maquette
