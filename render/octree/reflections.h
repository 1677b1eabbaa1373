#pragma once

#include "render/reflections/reflector_technique.h"

namespace maquette {

/// Traces the mirrored rays through the scene's octree and returns its cells as hits.
std::unique_ptr<ReflectorTechnique> make_octree_reflections();
/// The same for the rays of glossy opaque surfaces (shaders/reflections/glossy_rays.comp).
std::unique_ptr<ReflectorTechnique> make_glossy_octree_reflections();
std::vector<ShaderVariant> octree_reflection_shader_variants();

}  // namespace maquette
