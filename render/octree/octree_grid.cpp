// Placement of an octree's cells: root, core and finer regions.
#include <algorithm>
#include <cmath>

#include "render/octree/octree_build.h"
#include "render/octree/octree_triangles.h"

namespace maquette {

namespace {

constexpr int kBrickLevel = 4;
/// The root is this much wider than the surfaces, so that none lies on its upper faces, which belong to no cell.
constexpr double kMargin = 1.0 + 1.0 / 512.0;
/// An existing root is kept while the surfaces fill at least this share of it.
constexpr double kWorthKeeping = 0.7;
/// Share of the triangles at either end of an axis that may lie outside the core: the ground and objects on it.
constexpr double kOutliers = 0.08;
/// Items up to this multiple of the trimmed core's width, with their centre near it, belong entirely to the core.
constexpr double kMemberWidth = 1.5;
/// The core gets levels of its own only when the scene is at least this much wider.
constexpr double kCoreGain = 1.5;
/// With fewer triangles than this, outliers cannot be identified.
constexpr std::size_t kFewTriangles = 1000;
constexpr int kInterestLevels = 2;

double widest(const Bounds& b) {
  const glm::dvec3 extent = glm::dvec3(b.max) - glm::dvec3(b.min);
  return std::max({extent.x, extent.y, extent.z});
}

bool contains(const Bounds& outer, const Bounds& inner) {
  return glm::all(glm::lessThanEqual(outer.min, inner.min)) && glm::all(glm::greaterThanEqual(outer.max, inner.max));
}

void include(Bounds* b, const Bounds& other) {
  b->min = glm::min(b->min, other.min);
  b->max = glm::max(b->max, other.max);
}

/// Bounds of all surfaces, and of the core without outliers.
struct Extents {
  Bounds all, core;
  std::vector<Bounds> items;
};

Extents find_extents(const OctreeSource& source) {
  Extents extents;
  std::vector<float> middles[3];
  const auto bounds_of = [&](std::size_t first) {
    Bounds b;
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::vec3& p = source.geometry.positions[source.geometry.indices[first + k]];
      b.min = glm::min(b.min, p);
      b.max = glm::max(b.max, p);
    }
    return b;
  };
  extents.items.resize(source.geometry.items.size());
  for_each_triangle(source, [&](std::size_t first, std::size_t item) {
    const Bounds b = bounds_of(first);
    include(&extents.all, b);
    include(&extents.items[item], b);
    for (int axis = 0; axis < 3; ++axis) middles[axis].push_back(b.center()[axis]);
  });
  extents.core = extents.all;
  if (middles[0].size() < kFewTriangles) return extents;
  Bounds trimmed;
  for (int axis = 0; axis < 3; ++axis) {
    auto& m = middles[axis];
    const auto cut = static_cast<std::ptrdiff_t>(kOutliers * static_cast<double>(m.size()));
    std::nth_element(m.begin(), m.begin() + cut, m.end());
    trimmed.min[axis] = m[static_cast<std::size_t>(cut)];
    std::nth_element(m.begin(), m.end() - 1 - cut, m.end());
    trimmed.max[axis] = *(m.end() - 1 - cut);
  }
  const glm::vec3 room(0.03f * static_cast<float>(widest(trimmed)));
  const Bounds neighborhood{trimmed.min - 10.0f * room, trimmed.max + 10.0f * room};
  extents.core = {trimmed.min - room, trimmed.max + room};
  for (const Bounds& item : extents.items) {
    if (item.empty() || widest(item) > kMemberWidth * widest(trimmed)) continue;
    if (contains(neighborhood, {item.center(), item.center()})) include(&extents.core, item);
  }
  extents.core.min = glm::max(extents.core.min, extents.all.min);
  extents.core.max = glm::min(extents.core.max, extents.all.max);
  return extents;
}

}  // namespace

OctreeGrid compute_octree_grid(const OctreeSource& source, const OctreeOptions& options, const OctreeGrid* before) {
  OctreeGrid grid;
  const Extents extents = find_extents(source);
  if (extents.all.empty()) return grid;
  grid.core = extents.core;
  double core = widest(grid.core);
  const double all = std::max(widest(extents.all), 1e-30);
  if (!(core * kCoreGain < all)) {
    grid.core = extents.all;
    core = all;
  }
  const int outer =
      std::clamp(static_cast<int>(std::ceil(std::log2(all / std::max(core, 1e-30)))), 0, kOctreeMaxOuterLevels);
  grid.detail = std::clamp(options.detail, 0, std::min(kOctreeMaxDetail, kOctreeMaxLevels - options.depth - outer));
  grid.depth = options.depth + outer + grid.detail;
  const bool partly = !options.interest.empty();
  grid.rest_depth = partly      ? std::max(options.depth - kInterestLevels, 1)
                    : outer > 0 ? options.depth
                                : grid.depth - grid.detail;
  grid.brick_level = std::min(kBrickLevel, grid.rest_depth);
  // Rounded to float, the precision of the traversal, so that builder and traversal agree on the cells.
  grid.side_m = static_cast<float>(all * kMargin);
  grid.corner =
      glm::dvec3(glm::vec3(0.5 * (glm::dvec3(extents.all.min) + glm::dvec3(extents.all.max)) - 0.5 * grid.side_m));
  if (before && before->depth == grid.depth && before->detail == grid.detail && before->rest_depth == grid.rest_depth) {
    const Bounds root{glm::vec3(before->corner), glm::vec3(before->corner + before->side_m * (1.0 - 1.0 / 4096.0))};
    const bool fits = contains(root, extents.all) && all >= kWorthKeeping * before->side_m;
    const glm::vec3 room(0.05f * static_cast<float>(core));
    const bool same_core = contains({before->core.min - room, before->core.max + room}, grid.core) &&
                           core >= kWorthKeeping * widest(before->core);
    if (fits && same_core) {
      grid.corner = before->corner;
      grid.side_m = before->side_m;
      grid.core = before->core;
    }
  }
  if (partly)
    grid.fine = options.interest;
  else if (outer > 0)
    grid.fine = {grid.core};
  return grid;
}

}  // namespace maquette
