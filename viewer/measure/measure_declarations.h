#pragma once

#include <vector>

#include "viewer/command_line.h"

namespace maquette {

/// The options of `maquette measure` alone.
std::vector<OptionDeclaration> measure_option_declarations();

}  // namespace maquette
