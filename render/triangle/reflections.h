#pragma once

#include "render/gl/program_cache.h"
#include "render/reflections/reflector_technique.h"

namespace maquette {

/// Projects the scene into the triangles of the reflectors, and computes the hits of the mirrored rays there, per
/// pixel.
std::unique_ptr<ReflectorTechnique> make_triangle_reflections();
std::vector<ShaderVariant> triangle_shader_variants();

}  // namespace maquette
