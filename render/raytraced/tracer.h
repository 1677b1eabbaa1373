#pragma once

#include "render/reflections/reflector_technique.h"

namespace maquette {

/// Traces the mirrored rays with Embree, on all cores.
std::unique_ptr<ReflectorTechnique> make_raytraced_reflections();

}  // namespace maquette
