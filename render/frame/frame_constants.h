#pragma once

#include <cstddef>
#include <glm/glm.hpp>

namespace maquette {

namespace shared {
using namespace glm;
#include "shared/frame_block.glsl"
}  // namespace shared

using FrameConstants = shared::FrameConstants;
static_assert(offsetof(FrameConstants, eye) == 64);
static_assert(offsetof(FrameConstants, environment) == 128);
static_assert(offsetof(FrameConstants, size) == 144);
static_assert(offsetof(FrameConstants, bandwidth_size) == 192);
static_assert(offsetof(FrameConstants, section) == 224);
static_assert(sizeof(FrameConstants) == 256);

}  // namespace maquette
