#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "render/bezier/reflector_patch.h"
#include "render/frame/frame_constants.h"
#include "render/reflections/clusters.h"

namespace maquette {

/// The part of a patch that is visible in the picture, for culling.
struct PatchView {
  glm::vec4 window{-1.0f, -1.0f, 1.0f, 1.0f};  ///< lower and upper parameters of the visible part
  std::vector<Beam> beams;  ///< mirrored rays of each visible quad; empty when the patch is out of view
};

/// Tests `side` x `side` quads.
PatchView view_patch(const ReflectorPatch& patch, const FrameConstants& frame, int side = 16);

}  // namespace maquette
