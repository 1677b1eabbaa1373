// From bricks to one octree: the levels above them, and the nodes of all bricks level by level.
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <utility>
#include <vector>

#include "render/octree/octree_build.h"

namespace maquette {

namespace {

/// Mask and sums of a node above the bricks.
struct TopNode {
  std::uint32_t code = 0;
  std::uint8_t mask = 0;
  OctreeSums sums;  ///< in finest cells from the node's own lower corner
};

glm::dvec3 child_offset(std::uint32_t octant, double cell) {
  return cell * glm::dvec3(octant & 1u, octant >> 1 & 1u, octant >> 2);
}

std::vector<TopNode> join_top(const std::vector<TopNode>& children, double child_cell) {
  std::vector<TopNode> nodes;
  for (std::size_t first = 0; first < children.size();) {
    TopNode node;
    node.code = children[first].code >> 3;
    std::array<OctreeSums, 8> moved;
    std::array<const OctreeSums*, 8> parts{};
    for (; first < children.size() && children[first].code >> 3 == node.code; ++first) {
      const std::uint32_t octant = children[first].code & 7u;
      moved[octant] = children[first].sums;
      moved[octant].centroid += moved[octant].area * child_offset(octant, child_cell);
      parts[octant] = &moved[octant];
      node.mask = static_cast<std::uint8_t>(node.mask | 1u << octant);
    }
    node.sums = join_children(parts, child_cell);
    nodes.push_back(std::move(node));
  }
  return nodes;
}

}  // namespace

Octree assemble_octree(const OctreeBricks& bricks) {
  const OctreeGrid& grid = bricks.grid;
  Octree octree;
  octree.depth = grid.depth;
  octree.detail = grid.detail;
  octree.corner = glm::vec3(grid.corner);
  octree.side_m = static_cast<float>(grid.side_m);
  std::vector<const OctreeBrick*> filled;
  std::vector<std::vector<TopNode>> top(static_cast<std::size_t>(grid.brick_level) + 1);
  for (const auto& [code, entry] : bricks.bricks) {
    if (entry.brick.counts.empty()) continue;
    filled.push_back(&entry.brick);
    top.back().push_back({code, entry.brick.masks[0], entry.brick.sums});
  }
  if (filled.empty()) return octree;
  for (int level = grid.brick_level - 1; level >= 0; --level) {
    const auto l = static_cast<std::size_t>(level);
    top[l] = join_top(top[l + 1], std::exp2(grid.depth - level - 1));
  }
  // Drops levels without cells.
  const auto has_cells = [&](int level) {
    const auto l = static_cast<std::size_t>(level - grid.brick_level);
    return std::any_of(filled.begin(), filled.end(), [&](const OctreeBrick* b) { return b->counts[l] > 0; });
  };
  while (octree.depth > grid.depth - grid.detail && !has_cells(octree.depth)) --octree.depth, --octree.detail;
  const auto levels = static_cast<std::size_t>(octree.depth);
  const auto brick_level = static_cast<std::size_t>(grid.brick_level);
  std::uint32_t total = 0;
  for (std::size_t level = 0; level <= levels; ++level) {
    octree.level_begin[level] = total;
    if (level < brick_level)
      total += static_cast<std::uint32_t>(top[level].size());
    else
      for (const OctreeBrick* brick : filled) total += brick->counts[level - brick_level];
  }
  octree.level_begin[levels + 1] = total;
  octree.words.reserve(total);
  octree.colors.reserve(total);
  octree.triangles.reserve(total);
  octree.planes.reserve(octree.level_begin[levels]);
  std::vector<std::size_t> next(filled.size(), 0);  // per brick: its next node
  for (std::size_t level = 0; level <= levels; ++level) {
    std::uint32_t child = octree.level_begin[level + 1];
    const auto add = [&](std::uint32_t mask, const OctreeWords& words) {
      octree.colors.push_back(words.color);
      octree.triangles.push_back(words.triangle);
      if (level == levels) {
        octree.words.push_back(words.plane);
        return;
      }
      octree.planes.push_back(words.plane);
      octree.words.push_back(mask << 24 | child);
      child += static_cast<std::uint32_t>(std::popcount(mask));
    };
    if (level < brick_level) {
      const double cell = std::exp2(grid.depth - static_cast<int>(level));
      for (const TopNode& node : top[level]) add(node.mask, pack_node(node.sums, glm::dvec3(0.0), cell));
      continue;
    }
    for (std::size_t b = 0; b < filled.size(); ++b)
      for (std::uint32_t k = 0; k < filled[b]->counts[level - brick_level]; ++k, ++next[b])
        add(filled[b]->masks[next[b]], filled[b]->words[next[b]]);
  }
  return octree;
}

}  // namespace maquette
