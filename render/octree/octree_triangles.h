#pragma once

#include <cmath>
#include <cstddef>

#include "render/octree/octree_build.h"

namespace maquette {

/// True when all three corners exist and are finite.
inline bool is_usable_triangle(const FlatGeometry& g, std::size_t first_index) {
  for (std::size_t k = 0; k < 3; ++k) {
    const std::uint32_t v = g.indices[first_index + k];
    if (v >= g.positions.size()) return false;
    const glm::vec3& p = g.positions[v];
    if (!std::isfinite(p.x) || !std::isfinite(p.y) || !std::isfinite(p.z)) return false;
  }
  return true;
}

/// Calls `visit(first_index, item)` for every triangle of the octree.
template <typename Visit>
void for_each_triangle(const OctreeSource& source, Visit&& visit) {
  for (std::size_t i = 0; i < source.geometry.items.size(); ++i) {
    if (source.transmits[i]) continue;
    const DrawItem& item = source.geometry.items[i];
    const std::size_t end = std::size_t{item.first_index} + item.index_count;
    for (std::size_t first = item.first_index; first + 3 <= end; first += 3)
      if (is_usable_triangle(source.geometry, first)) visit(first, i);
  }
}

}  // namespace maquette
