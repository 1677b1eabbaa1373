#pragma once

#include "render/reflections/reflector_technique.h"

namespace maquette {

/// Sends the mirrored rays through the scene's octree; their hits are its cells.
std::unique_ptr<ReflectorTechnique> make_octree_reflections();
/// The same for the rays of glossy opaque surfaces (shaders/reflections/glossy_rays.comp).
std::unique_ptr<ReflectorTechnique> make_glossy_reflections();
ShaderVariant octree_reflect_variant(bool cells, bool glossy);
ShaderVariant shade_cells_variant(bool traced);

}  // namespace maquette
