#pragma once

#include "render/technique/technique.h"

namespace maquette {

/// Settings that all reflector techniques share.
Technique reflections_technique();
/// Quality steps by `reflections.resolution`, from quarter to full.
std::vector<QualityStep> resolution_steps();

/// For techniques whose hits are triangles: plans the pass that finds their surfaces.
void add_resolve_pass(FramePlan* plan);

}  // namespace maquette
