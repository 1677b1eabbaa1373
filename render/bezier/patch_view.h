#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "render/bezier/reflector_patch.h"
#include "render/frame/frame_constants.h"
#include "render/reflections/clusters.h"

namespace maquette {

/// What the picture shows of a patch: culling keeps to it.
struct PatchView {
  glm::vec4 window{-1.0f, -1.0f, 1.0f, 1.0f};  ///< lower and upper parameters that may be in the picture
  std::vector<Beam> beams;                     ///< mirrored rays of each part that may be; none where it is out of view
};

/// In `side` x `side` quads.
PatchView view_patch(const ReflectorPatch& patch, const FrameConstants& frame, int side = 16);

}  // namespace maquette
