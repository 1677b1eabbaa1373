#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace maquette {

inline constexpr int kOctreeMaxDepth = 10;
/// Extra levels above, for the surroundings of the core, which contains nearly all triangles of the scene.
inline constexpr int kOctreeMaxOuterLevels = 3;
/// Extra levels below, for cells that hold more detail than one normal and one colour.
inline constexpr int kOctreeMaxDetail = 2;
/// Less than the sum of the three: codes of cells inside a brick have 10 bits an axis.
inline constexpr int kOctreeMaxLevels = 14;
/// First-child pointers have 24 bits, and 2^24 attributes of 8 bytes are 128 MiB, the storage buffer size that drivers
/// guarantee.
inline constexpr std::size_t kOctreeMaxNodes = std::size_t{1} << 24;
inline constexpr int kOctreeMaxMaterials = 4095;

/// Sparse octree of a scene's surfaces, nodes in breadth-first order, the children of a node side by side in the order
/// x + 2 y + 4 z. Level 0 is the root; cells of level `depth` have the size side_m / 2^depth.
///
/// `words[i]`: for nodes above the last level child mask << 24
/// index of the first child (mask 0: a leaf in a coarse region); for nodes of the last level their plane word.
/// `planes[i]`: plane word of the nodes above the last level. `colors[i]`: colour word of all nodes. Layout of both:
/// shaders/shared/octree.glsl. `triangles[i]`: the triangle of the geometry that represents the node: the largest one
/// of the node's material.
struct Octree {
  glm::vec3 corner{0.0f};  ///< lower corner of the root, m
  float side_m = 1.0f;
  int depth = 0;
  int detail = 0;  ///< number of its levels that only detailed cells have
  std::vector<std::uint32_t> words, planes, colors, triangles;
  /// Index of the first node of each level; level_begin[depth + 1] is the number of nodes.
  std::array<std::uint32_t, kOctreeMaxLevels + 2> level_begin{};

  bool empty() const { return words.empty(); }
  std::size_t node_count() const { return words.size(); }
  std::size_t leaf_count() const { return leaf_count(0); }
  /// Leaves of this level and of finer ones.
  std::size_t leaf_count(int level) const;
  std::size_t bytes() const { return 4 * (words.size() + planes.size() + colors.size() + triangles.size()); }
};

/// One node with its cell, found by traversal: for tests, statistics and bakes. Integer coordinates count cells of
/// `level`.
struct OctreeCell {
  std::uint32_t node = 0;
  int level = 0;
  glm::ivec3 coordinate{0};
};
/// All leaves in depth-first order.
std::vector<OctreeCell> list_leaves(const Octree& octree);

}  // namespace maquette
