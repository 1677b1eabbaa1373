#pragma once

#include "render/frame/frame_constants.h"
#include "render/frame/request.h"
#include "render/gbuffer/tiles.h"
#include "render/scene_state/scene_state.h"

namespace maquette {

/// What all layers of a frame have in common; their modes set levels, samples and quality.
FrameConstants make_frame_constants(const SceneState& scene, const FrameRequest& request, const GridSize& size);

}  // namespace maquette
