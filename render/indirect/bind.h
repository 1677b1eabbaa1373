#pragma once

#include "render/gl/objects.h"
#include "render/gl/program_cache.h"
#include "render/indirect/indirect_buffers.h"
#include "render/scene_state/scene_state.h"

namespace maquette {

/// Binds one bake for shaders that load it (shaders/shading/load_indirect.glsl).
void bind_indirect(const Program& program, const SceneState& scene, const IndirectKey& key);
/// The bake that a frame is nearest to.
const IndirectKey& nearest_bake(const IndirectBuffers& indirect);
ShaderVariant reflected_indirect_variant(bool measured);

}  // namespace maquette
