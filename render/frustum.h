#pragma once

#include <glm/glm.hpp>

#include "scenes/scene.h"

namespace maquette {

/// False when a box lies outside one of the frustum's side planes (in clip space; the far plane is at infinity).
bool may_be_seen(const glm::mat4& clip_from_world, const Bounds& bounds);

}  // namespace maquette
