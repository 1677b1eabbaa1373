#pragma once

#include <glm/glm.hpp>

#include "scenes/scene.h"

namespace maquette {

/// Share of the upper hemisphere around `eye` (world, metres) in which the nearest surface is an opaque one seen from
/// its front (or double-sided): 1 in a closed room, 0 in the open, and 0 inside a solid. Panes and blended surfaces let
/// light through. Exact at 6 x 16 x 16 directions of a cube, weighted by solid angle. Cost: linear in triangles, about
/// 10 ms for 300,000.
double covered_share(const Scene& scene, int variant, const glm::vec3& eye);

/// Whether a typical eye of the scene (that of its first camera, or the middle of its bounds) has more than half of the
/// sky covered: then shading without visibility would light it through the roof.
bool is_enclosed(const Scene& scene, int variant);

}  // namespace maquette
