#include "render/reflections/coarse_patches.h"

#include <algorithm>
#include <limits>

namespace maquette {

namespace {

constexpr std::uint32_t kCoarsestQuads = 16;

PatchSides sides_of_patch(const FlatGeometry& geometry, const DrawItem& patch) {
  // The two triangles of the first quad contain the second vertex of the second row, whatever the winding.
  const std::uint32_t* first = geometry.indices.data() + patch.first_index;
  const auto columns = static_cast<int>(*std::max_element(first, first + 6) - patch.first_vertex) - 2;
  return {columns, static_cast<int>(patch.vertex_count) / (columns + 1) - 1};
}

/// The vertices of a patch, row by row.
class Grid {
 public:
  Grid(const FlatGeometry& geometry, const DrawItem& item)
      : geometry_(geometry), first_(item.first_vertex), sides_(sides_of_patch(geometry, item)) {
    rewound_ = geometry.indices[item.first_index + 1] != first_ + 1;
  }
  const PatchSides& sides() const { return sides_; }
  std::uint32_t columns() const { return static_cast<std::uint32_t>(sides_.u); }
  std::uint32_t rows() const { return static_cast<std::uint32_t>(sides_.v); }
  std::uint32_t index(std::uint32_t row, std::uint32_t column) const { return first_ + row * (columns() + 1) + column; }
  glm::vec3 at(std::uint32_t row, std::uint32_t column) const { return geometry_.positions[index(row, column)]; }
  bool rewound() const { return rewound_; }

 private:
  const FlatGeometry& geometry_;
  std::uint32_t first_;
  PatchSides sides_;
  bool rewound_;
};

/// One coarse quad, with the diagonal of tessellate_patch.
struct CoarseQuad {
  std::uint32_t row, column, next_row, next_column;
};

float deviation_of(const Grid& grid, const CoarseQuad& q) {
  const glm::vec3 a = grid.at(q.row, q.column), b = grid.at(q.row, q.next_column), c = grid.at(q.next_row, q.column),
                  d = grid.at(q.next_row, q.next_column);
  float most = 0.0f;
  for (std::uint32_t row = q.row; row <= q.next_row; ++row) {
    for (std::uint32_t column = q.column; column <= q.next_column; ++column) {
      const float u = static_cast<float>(column - q.column) / static_cast<float>(q.next_column - q.column),
                  v = static_cast<float>(row - q.row) / static_cast<float>(q.next_row - q.row);
      const glm::vec3 p = u >= v ? a + u * (b - a) + v * (d - b) : a + v * (c - a) + u * (d - c);
      most = std::max(most, glm::length(p - grid.at(row, column)));
    }
  }
  return most;
}

template <typename Visit>
void for_each_quad(const Grid& grid, std::uint32_t quads, const Visit& visit) {
  for (std::uint32_t row = 0; row < grid.rows(); row += quads)
    for (std::uint32_t column = 0; column < grid.columns(); column += quads)
      visit(CoarseQuad{row, column, std::min(row + quads, grid.rows()), std::min(column + quads, grid.columns())});
}

CoarsePatch::Level make_level(const Grid& grid, std::uint32_t quads, std::vector<std::uint32_t>* indices) {
  CoarsePatch::Level level;
  level.quads = quads;
  level.first_index = static_cast<std::uint32_t>(indices->size());
  for_each_quad(grid, quads, [&](const CoarseQuad& q) {
    const std::uint32_t a = grid.index(q.row, q.column), b = grid.index(q.row, q.next_column),
                        c = grid.index(q.next_row, q.column), d = grid.index(q.next_row, q.next_column);
    if (grid.rewound())
      indices->insert(indices->end(), {a, d, b, a, c, d});
    else
      indices->insert(indices->end(), {a, b, d, a, d, c});
    level.deviation_m = std::max(level.deviation_m, deviation_of(grid, q));
  });
  level.index_count = static_cast<std::uint32_t>(indices->size()) - level.first_index;
  return level;
}

}  // namespace

CoarsePatches make_coarse_patches(const FlatGeometry& geometry) {
  CoarsePatches patches;
  for (std::size_t i = 0; i < geometry.items.size(); ++i) {
    const DrawItem& item = geometry.items[i];
    if (item.patch < 0 || item.index_count == 0) continue;
    const Grid grid(geometry, item);
    CoarsePatch& patch = patches.of_item[i];
    patch.sides = grid.sides();
    for (std::uint32_t quads = 2; quads <= kCoarsestQuads; quads *= 2)
      patch.levels.push_back(make_level(grid, quads, &patches.indices));
    // In a triangle no point is farther from the nearest corner than the longest edge.
    for_each_quad(grid, kCoarsestQuads, [&](const CoarseQuad& q) {
      const glm::vec3 a = grid.at(q.row, q.column), b = grid.at(q.row, q.next_column),
                      c = grid.at(q.next_row, q.column), d = grid.at(q.next_row, q.next_column);
      patch.corners.insert(patch.corners.end(), {a, b, c, d});
      for (const glm::vec3& edge : {b - a, c - a, d - b, d - c, d - a})
        patch.extent_m = std::max(patch.extent_m, glm::length(edge));
    });
    patch.extent_m += patch.levels.back().deviation_m;
  }
  return patches;
}

const CoarsePatch::Level* coarsest_level(const CoarsePatch& patch, const glm::vec3& eye, float tolerance_rad) {
  float nearest_m = std::numeric_limits<float>::max();
  for (const glm::vec3& corner : patch.corners) nearest_m = std::min(nearest_m, glm::length(corner - eye));
  const float allowed_m = tolerance_rad * (nearest_m - patch.extent_m);
  const CoarsePatch::Level* coarsest = nullptr;
  for (const CoarsePatch::Level& level : patch.levels)
    if (level.deviation_m <= allowed_m) coarsest = &level;
  return coarsest;
}

}  // namespace maquette
