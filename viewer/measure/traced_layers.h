#pragma once

#include <vector>

#include "render/inspection/sights.h"
#include "render/reference/reference.h"
#include "scenes/image.h"
#include "viewer/measure/measurement.h"

namespace maquette {

/// The eye ray of each pixel, row by row from the top.
struct EyeRays {
  std::vector<glm::vec3> origins, directions;
};

/// Path-traced radiance of what the nearest pane of each pixel reflects and lets through, `paths` a pixel and side;
/// pixels without a pane have what they show in `transmitted`. `pixels`: which to trace; others stay black. All light
/// paths; deterministic by `seed`.
LayerPictures trace_layers(const PathScene& scene, const PathOptions& options, const EyeRays& rays,
                           const std::vector<std::size_t>& pixels, glm::ivec2 size, int paths, std::uint32_t seed);

}  // namespace maquette
