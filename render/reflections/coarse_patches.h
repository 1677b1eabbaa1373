#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <vector>

#include "render/scene_state/geometry.h"
#include "scenes/subdivision.h"

namespace maquette {

/// A patch with several of its quads merged into one. Software devices transform vertices on one core, and the
/// intersection of a pixel's ray with the patch is computed in the pixel: the triangles only need to cover it.
struct CoarsePatch {
  struct Level {
    std::uint32_t quads = 1;   ///< merged quads along each side
    float deviation_m = 0.0f;  ///< largest distance of a vertex from the coarse triangles, at its own parameters
    std::uint32_t first_index = 0, index_count = 0;  ///< in CoarsePatches::indices
  };
  PatchSides sides;                ///< of the patch's own triangles
  std::vector<Level> levels;       ///< from fine to coarse
  std::vector<glm::vec3> corners;  ///< of the coarsest quads, m
  float extent_m = 0.0f;           ///< largest distance of a point of the patch from the nearest corner
};

struct CoarsePatches {
  std::vector<std::uint32_t> indices;  ///< indices into the geometry's vertices, with the winding of its triangles
  std::map<std::size_t, CoarsePatch> of_item;  ///< of all patches
};

CoarsePatches make_coarse_patches(const FlatGeometry& geometry);

/// The coarsest level that no vertex is seen to deviate from by more than `tolerance_rad`; null when only the patch's
/// own triangles are accurate enough.
const CoarsePatch::Level* coarsest_level(const CoarsePatch& patch, const glm::vec3& eye, float tolerance_rad);

}  // namespace maquette
