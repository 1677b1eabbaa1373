#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace maquette {

inline constexpr int kOctreeMaxDepth = 10;
/// Levels above those for what lies around the part of a scene that holds nearly all of its triangles.
inline constexpr int kOctreeMaxOuterLevels = 3;
/// Levels below those for cells that hold more than one normal and one colour can say.
inline constexpr int kOctreeMaxDetail = 2;
/// Fewer than their sum: codes of cells inside a brick have 10 bits an axis.
inline constexpr int kOctreeMaxLevels = 14;
/// First-child pointers have 24 bits, and 2^24 attributes of 8 bytes are 128 MiB, the storage a driver promises.
inline constexpr std::size_t kOctreeMaxNodes = std::size_t{1} << 24;
inline constexpr int kOctreeMaxMaterials = 4095;

/// Sparse octree of a scene's surfaces, nodes in breadth-first order, the children of a node side by side in the order
/// x + 2 y + 4 z. Level 0 is the root, cells of level `depth` have side_m / 2^depth.
///
/// `words[i]`: of nodes above the last level child mask << 24 | index of the first child (mask 0: a leaf in a coarse
/// region); of nodes of the last level their plane word. `planes[i]` is the plane word of the nodes above the last
/// level, `colors[i]` the colour word of all. Layout of both: shaders/shared/octree.glsl. `triangles[i]`: the triangle
/// of the geometry that stands for the node, of what its colour is of the one with the largest area.
struct Octree {
  glm::vec3 corner{0.0f};  ///< lower corner of the root, m
  float side_m = 1.0f;
  int depth = 0;
  int detail = 0;  ///< of its levels, those that only cells of much detail have
  std::vector<std::uint32_t> words, planes, colors, triangles;
  /// Index of the first node of each level; level_begin[depth + 1] is the number of nodes.
  std::array<std::uint32_t, kOctreeMaxLevels + 2> level_begin{};

  bool empty() const { return words.empty(); }
  std::size_t node_count() const { return words.size(); }
  std::size_t leaf_count() const { return leaf_count(0); }
  /// Those of this level and finer ones.
  std::size_t leaf_count(int level) const;
  std::size_t bytes() const { return 4 * (words.size() + planes.size() + colors.size() + triangles.size()); }
};

/// One node with its cell, found by walking the tree: for tests, statistics and bakes. Integer coordinates count cells
/// of `level`.
struct OctreeCell {
  std::uint32_t node = 0;
  int level = 0;
  glm::ivec3 coordinate{0};
};
/// All leaves in depth-first order.
std::vector<OctreeCell> list_leaves(const Octree& octree);

}  // namespace maquette
