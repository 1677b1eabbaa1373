#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <map>
#include <vector>

#include "render/geometry.h"
#include "scenes/subdivision.h"

namespace maquette {

/// A patch as fewer triangles, several of its quads in one. Software devices transform vertices on one core, and where
/// a pixel's ray meets the patch is found in the pixel: the triangles need only cover it.
struct CoarsePatch {
  struct Level {
    std::uint32_t quads = 1;                         ///< along either side of a coarse one
    float deviation_m = 0.0f;                        ///< of a vertex from the coarse triangles, at its own parameters
    std::uint32_t first_index = 0, index_count = 0;  ///< in CoarsePatches::indices
  };
  PatchSides sides;                ///< of the patch's own triangles
  std::vector<Level> levels;       ///< from fine to coarse
  std::vector<glm::vec3> corners;  ///< of the coarsest quads, m
  float reach_m = 0.0f;            ///< farther than this from the nearest corner is no point of the patch
};

struct CoarsePatches {
  std::vector<std::uint32_t> indices;          ///< of the geometry's vertices, wound as its triangles
  std::map<std::size_t, CoarsePatch> of_item;  ///< of all patches
};

CoarsePatches make_coarse_patches(const FlatGeometry& geometry);

/// The coarsest that no vertex is seen off by more than `tolerance_rad`; null where only the patch's own triangles are
/// good enough.
const CoarsePatch::Level* coarsest_level(const CoarsePatch& patch, const glm::vec3& eye, float tolerance_rad);

}  // namespace maquette
