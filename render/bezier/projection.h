#pragma once

#include "render/gl/program_cache.h"
#include "render/reflections/reflector_technique.h"

namespace maquette {

/// Projects the scene into the patches of the reflectors and rasterises it there.
std::unique_ptr<ReflectorTechnique> make_bezier_reflections();
std::vector<ShaderVariant> bezier_shader_variants();

}  // namespace maquette
