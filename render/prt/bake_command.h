#pragma once

#include "render/bake/bake_command.h"

namespace maquette {

/// `maquette bake prt`: transfer, resumable; under `mpirun` several processes share it.
BakeCommand transfer_bake_command();

}  // namespace maquette
