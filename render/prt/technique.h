#pragma once

#include "render/technique/technique.h"

namespace maquette {

Technique prt_technique();

}  // namespace maquette
