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

/// Panes as sheets of glass, whose back faces mirror a second image.
struct GhostSheet {
  float thickness_m = 0.0f;
  float wedge_rad = 0.0f;    ///< thicker upwards
  bool in_reflected = true;  ///< else the second image lies on the first one there
};

/// Path-traced radiance of what the nearest pane of each pixel reflects and lets through, `paths` a pixel and side;
/// pixels without a pane have what they show in `transmitted`. `pixels`: which to trace; others stay black.
/// `ghost`: of what the second images show; panes are locally flat. Deterministic by `seed`.
LayerPictures trace_layers(const PathScene& scene, const PathOptions& options, const EyeRays& rays,
                           const std::vector<std::size_t>& pixels, glm::ivec2 size, int paths, std::uint32_t seed,
                           const std::optional<GhostSheet>& ghost = {});

}  // namespace maquette
