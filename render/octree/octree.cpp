#include "render/octree/octree.h"

#include <bit>

namespace maquette {

namespace {

void walk(const Octree& octree, const OctreeCell& cell, std::vector<OctreeCell>* leaves) {
  const std::uint32_t mask = cell.level < octree.depth ? octree.words[cell.node] >> 24 : 0u;
  if (mask == 0u) {
    leaves->push_back(cell);
    return;
  }
  std::uint32_t child = octree.words[cell.node] & 0xffffffu;
  for (int k = 0; k < 8; ++k) {
    if (!(mask >> k & 1u)) continue;
    walk(octree, {child++, cell.level + 1, 2 * cell.coordinate + glm::ivec3(k & 1, k >> 1 & 1, k >> 2)}, leaves);
  }
}

}  // namespace

std::size_t Octree::leaf_count(int level) const {
  std::size_t count = words.size() - level_begin[static_cast<std::size_t>(depth)];
  for (std::size_t i = level_begin[static_cast<std::size_t>(level)]; i < level_begin[static_cast<std::size_t>(depth)];
       ++i)
    count += words[i] >> 24 == 0u;
  return count;
}

std::vector<OctreeCell> list_leaves(const Octree& octree) {
  std::vector<OctreeCell> leaves;
  if (!octree.empty()) walk(octree, {}, &leaves);
  return leaves;
}

}  // namespace maquette
