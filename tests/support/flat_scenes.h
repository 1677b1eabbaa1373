// Geometry of the tests of baked visibility.
#pragma once

#include "render/scene_state/geometry.h"

namespace maquette::test {

/// Item of n x n quads over o + [0, 1] u + [0, 1] v with one normal.
inline void add_grid(FlatGeometry* g, const glm::vec3& o, const glm::vec3& u, const glm::vec3& v, int n = 1) {
  DrawItem item;
  item.first_index = static_cast<std::uint32_t>(g->indices.size());
  item.first_vertex = static_cast<std::uint32_t>(g->positions.size());
  const glm::vec3 normal = glm::normalize(glm::cross(u, v));
  for (int j = 0; j <= n; ++j) {
    for (int i = 0; i <= n; ++i) {
      g->positions.push_back(o + u * (static_cast<float>(i) / static_cast<float>(n)) +
                             v * (static_cast<float>(j) / static_cast<float>(n)));
      g->normals.push_back(normal);
    }
  }
  const auto row = static_cast<std::uint32_t>(n + 1);
  for (std::uint32_t j = 0; j + 1 < row; ++j) {
    for (std::uint32_t i = 0; i + 1 < row; ++i) {
      const std::uint32_t a = item.first_vertex + j * row + i;
      for (std::uint32_t k : {a, a + 1, a + row + 1, a, a + row + 1, a + row}) g->indices.push_back(k);
    }
  }
  item.index_count = static_cast<std::uint32_t>(g->indices.size()) - item.first_index;
  item.vertex_count = static_cast<std::uint32_t>(g->positions.size()) - item.first_vertex;
  g->items.push_back(item);
}

/// Six faces with outward normals, each its own four vertices: -x, +x, -y, +y, -z, +z.
inline void add_box(FlatGeometry* g, const glm::vec3& low, const glm::vec3& high) {
  const glm::vec3 x(high.x - low.x, 0.0f, 0.0f);
  const glm::vec3 y(0.0f, high.y - low.y, 0.0f);
  const glm::vec3 z(0.0f, 0.0f, high.z - low.z);
  add_grid(g, low, z, y);
  add_grid(g, low + x, y, z);
  add_grid(g, low, x, z);
  add_grid(g, low + y, z, x);
  add_grid(g, low, y, x);
  add_grid(g, low + z, x, y);
}

}  // namespace maquette::test
