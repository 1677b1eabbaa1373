#pragma once

#include "render/frame/frame_constants.h"
#include "render/frame/request.h"
#include "render/gbuffer/tiles.h"
#include "render/scene_state/scene_state.h"

namespace maquette {

/// What all layers of a frame have in common; their modes set levels, samples and quality.
FrameConstants make_frame_constants(const SceneState& scene, const FrameRequest& request, const GridSize& size);

/// As in shaders/shared/frame.glsl: from where the ray through a world point starts to that point, m.
glm::vec3 from_eye(const FrameConstants& frame, const glm::vec3& world);
/// Width of a pixel at a depth, m.
float pixel_width(const FrameConstants& frame, float depth);

}  // namespace maquette
