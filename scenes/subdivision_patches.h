#pragma once

#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "scenes/scene.h"

namespace maquette {

/// The limit surface of a cage as bicubic Bezier patches. Faces among vertices of four edges are such patches exactly;
/// around any other vertex the cage is refined first, and what is left beside it is the bicubic through 4 x 4 points of
/// OpenSubdiv's Gregory cap: it meets its neighbours along the border and misses the limit a little.
struct LimitPatches {
  std::vector<std::array<glm::dvec3, 16>> points;  ///< [row v][column u]
  std::vector<bool> exact;                         ///< no cap
  std::vector<int> patch_of_triangle;              ///< [triangle of SubdivisionEvaluator::indices()]
  std::vector<std::array<glm::dvec2, 3>> x;        ///< its corners' parameters there, [-1, 1]
};

/// `isolation`: refinements around what is not regular, at most the cage's levels. Throws Error for a cage that is no
/// surface. Source: Niessner et al. 2012, "Feature-adaptive GPU rendering of Catmull-Clark subdivision surfaces".
LimitPatches make_limit_patches(const SubdivisionCage& cage, int isolation);

}  // namespace maquette
