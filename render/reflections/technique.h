#pragma once

#include "render/registry.h"

namespace maquette {

/// Settings that all reflector techniques share.
TechniqueInfo reflections_technique();
/// Quality steps by `reflections.resolution`, from quarter to full.
std::vector<QualityStep> resolution_steps();

}  // namespace maquette
