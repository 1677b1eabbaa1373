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
  std::vector<glm::vec2> seen_m;  ///< from and to, along each: a section plane cuts off the rest

  Ray at(std::size_t pixel) const { return {origins[pixel], directions[pixel], seen_m[pixel].x, seen_m[pixel].y}; }
};

/// Path-traced radiance of what the nearest pane of each pixel reflects and lets through, `paths` a pixel and side;
/// pixels without a pane have what they show in `transmitted`. `pixels`: which to trace; others stay black.
/// Deterministic by `seed`.
LayerPictures trace_layers(const PathScene& scene, const PathOptions& options, const EyeRays& rays,
                           const std::vector<std::size_t>& pixels, glm::ivec2 size, int paths, std::uint32_t seed);

}  // namespace maquette
