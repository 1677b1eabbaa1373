#pragma once

#include "render/gl/program_cache.h"
#include "render/reflections/reflector_technique.h"

namespace maquette {

/// Projects the scene into the triangles of the reflectors and finds there, pixel by pixel, what the mirrored rays hit.
std::unique_ptr<ReflectorTechnique> make_triangle_reflections();
std::vector<ShaderVariant> triangle_shader_variants();

}  // namespace maquette
