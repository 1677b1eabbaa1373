#pragma once

// shaders/shared/octree.glsl as C++: the very lines that the GPU compiles.
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

#include "render/octree/octree.h"

#ifndef MAQUETTE_FN
#define MAQUETTE_FN inline
#endif

namespace maquette::shared {
using namespace glm;

/// What the walk and the surface read; set it before a trace on this thread.
struct OctreeView {
  const std::uint32_t* words = nullptr;
  const std::uint32_t* planes = nullptr;
  const std::uint32_t* colors = nullptr;
};
inline thread_local OctreeView octree_view;
inline uint octree_word(int node) { return octree_view.words[node]; }
inline uint octree_plane_word(int node) { return octree_view.planes[node]; }
inline uint octree_color_word(int node) { return octree_view.colors[node]; }

#include "shared/cell_brdf.glsl"
#include "shared/octree.glsl"
#include "shared/octree_surface.glsl"

inline OctreeFrame octree_frame(const Octree& octree) {
  return {octree.corner, std::exp2(static_cast<float>(octree.depth)) / octree.side_m, octree.depth, octree.detail};
}
}  // namespace maquette::shared
