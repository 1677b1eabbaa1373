#pragma once

#include "render/bake/bake_command.h"

namespace maquette {

/// `maquette bake prt`: transfer, resumable; under `mpirun` several processes share it.
BakeCommand transfer_bake_command();
/// Names of the settings that decide what is baked.
std::vector<std::string> transfer_bake_settings();

}  // namespace maquette
