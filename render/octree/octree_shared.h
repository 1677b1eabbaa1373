#pragma once

// shaders/shared/octree.glsl compiled as C++: the same source as on the GPU.
#include <cmath>

#include "render/math/shared_formulas.h"
#include "render/octree/octree.h"

namespace maquette::shared {

/// Inputs of the traversal and of surface lookups; set it before a trace on this thread.
struct OctreeView {
  const std::uint32_t* words = nullptr;
  const std::uint32_t* planes = nullptr;
  const std::uint32_t* colors = nullptr;
};
inline thread_local OctreeView octree_view;
inline uint octree_word(int node) { return octree_view.words[node]; }
inline uint octree_plane_word(int node) { return octree_view.planes[node]; }
inline uint octree_color_word(int node) { return octree_view.colors[node]; }

// The traversal calls these in every cell; GLM's versions take a dozen steps.
inline int findMSB(int v) { return 31 - std::countl_zero(static_cast<uint>(v)); }
inline int bitCount(uint v) {
  v -= (v >> 1) & 0x55555555u;
  v = (v & 0x33333333u) + ((v >> 2) & 0x33333333u);
  return static_cast<int>((((v + (v >> 4)) & 0x0f0f0f0fu) * 0x01010101u) >> 24);
}

#include "shared/cell_brdf.glsl"
#include "shared/octree.glsl"
#include "shared/octree_surface.glsl"

inline OctreeFrame octree_frame(const Octree& octree) {
  return {octree.corner, std::exp2(static_cast<float>(octree.depth)) / octree.side_m, octree.depth, octree.detail};
}
}  // namespace maquette::shared
