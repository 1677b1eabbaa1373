#pragma once

#include "render/technique/technique.h"

namespace maquette {

Technique slf_technique();

}  // namespace maquette
