#pragma once

#include "render/technique/technique.h"

namespace maquette {

Technique splitsum_technique();

}  // namespace maquette
