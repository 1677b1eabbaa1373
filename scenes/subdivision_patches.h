#pragma once

#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "scenes/scene.h"

namespace maquette {

/// The limit surface of a cage as bicubic Bezier patches. Faces whose vertices all have four edges are such patches
/// exactly. Around other vertices the cage is refined first, and each remaining face is approximated by the bicubic
/// through 4 x 4 points of OpenSubdiv's Gregory cap: continuous along the border, with a small error inside.
struct LimitPatches {
  std::vector<std::array<glm::dvec3, 16>> points;  ///< [row v][column u]
  std::vector<bool> exact;                         ///< not a cap
  std::vector<int> patch_of_triangle;              ///< [triangle of SubdivisionEvaluator::indices()]
  std::vector<std::array<glm::dvec2, 3>> x;        ///< parameters of its corners on that patch, [-1, 1]
};

/// `isolation`: number of refinements around irregular vertices, at most the cage's levels. Throws Error for a cage
/// that is no surface. Source: Niessner et al. 2012, "Feature-adaptive GPU rendering of Catmull-Clark subdivision
/// surfaces".
LimitPatches make_limit_patches(const SubdivisionCage& cage, int isolation);

}  // namespace maquette
