#pragma once

// shaders/shared/octree.glsl as C++: the very lines that the GPU compiles.
#include <bit>
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

// GLM's own go through their bits in a dozen steps, and the walk asks for them in every cell.
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
