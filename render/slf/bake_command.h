#pragma once

#include "render/bake/bake_command.h"

namespace maquette {

/// `maquette bake slf`: incident light, resumable; under `mpirun` several processes share it.
BakeCommand light_field_bake_command();
/// Names of the settings that decide what is baked.
std::vector<std::string> light_field_bake_settings();

}  // namespace maquette
