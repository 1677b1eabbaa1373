#pragma once

#include "render/reference/path_scene.h"

namespace maquette {

/// As PathScene holds it. `tables`: of `source`; their bandwidth is not used.
TracedEnvironment trace_environment(std::shared_ptr<const Environment> source, EnvironmentTables tables);

}  // namespace maquette
