#pragma once

#include "render/reflections/reflector_technique.h"

namespace maquette {

/// Traces the mirrored rays with Embree, on all cores.
std::unique_ptr<ReflectorTechnique> make_raytraced_reflections();
/// The same for the rays of glossy opaque surfaces (shaders/reflections/glossy_rays.comp).
std::unique_ptr<ReflectorTechnique> make_glossy_raytraced_reflections();

}  // namespace maquette
