#include "render/reference/triangle_pairs.h"

#include <algorithm>
#include <limits>
#include <tuple>

#include "scenes/parallel.h"
#include "scenes/scene.h"

namespace maquette {

namespace {

constexpr std::uint32_t kNone = std::numeric_limits<std::uint32_t>::max();
/// Largest area of the box around both triangles over the sum of their own boxes' areas: 0.5 for halves of a rectangle,
/// 1 for triangles in a strip. Above 1 a ray hits the pair's box more often than the two boxes.
constexpr float kMostGrowth = 1.0f;

/// Half-edge k of triangle t, the k-th of the list, is 3 t + k and runs from its k-th corner to the next one.
class Neighbours {
 public:
  Neighbours(std::span<const std::uint32_t> triangles, std::span<const glm::vec3> positions,
             std::span<const std::uint32_t> indices)
      : triangles_(triangles), positions_(positions), indices_(indices), twins_(3 * triangles.size(), kNone) {
    match_twins(edges_at_vertices());
  }

  /// The half-edge of the neighbour along the same edge, kNone: there is no neighbour.
  std::uint32_t twin(std::uint32_t half_edge) const { return twins_[half_edge]; }

  /// Area of the box around a triangle and its neighbour across an edge, over the sum of their boxes' areas.
  float growth(std::uint32_t half_edge) const {
    const Bounds a = bounds(half_edge / 3), b = bounds(twins_[half_edge] / 3);
    Bounds both = a;
    both.min = glm::min(both.min, b.min);
    both.max = glm::max(both.max, b.max);
    return surface(both) / std::max(surface(a) + surface(b), std::numeric_limits<float>::min());
  }

  /// The edge with the least growth, among those to neighbours that are `free`.
  template <typename Free>
  std::uint32_t best_edge(std::uint32_t triangle, const Free& free) const {
    std::uint32_t best = kNone;
    float least = kMostGrowth;
    for (std::uint32_t edge = 3 * triangle; edge < 3 * triangle + 3; ++edge) {
      if (twins_[edge] == kNone || twins_[edge] / 3 == triangle || !free(twins_[edge] / 3)) continue;
      if (const float g = growth(edge); g <= least && (g < least || best == kNone)) {
        least = g;
        best = edge;
      }
    }
    return best;
  }

 private:
  std::uint32_t corner(std::uint32_t triangle, std::uint32_t k) const {
    return indices_[3 * std::size_t{triangles_[triangle]} + k % 3];
  }
  /// A half-edge by its ends, the lower one first.
  struct Ends {
    std::uint32_t low, high;
    bool upwards;
  };
  Ends ends(std::uint32_t edge) const {
    const std::uint32_t from = corner(edge / 3, edge % 3), to = corner(edge / 3, edge % 3 + 1);
    return {std::min(from, to), std::max(from, to), from < to};
  }

  Bounds bounds(std::uint32_t triangle) const {
    Bounds b;
    for (std::uint32_t k = 0; k < 3; ++k) {
      b.min = glm::min(b.min, positions_[corner(triangle, k)]);
      b.max = glm::max(b.max, positions_[corner(triangle, k)]);
    }
    return b;
  }
  static float surface(const Bounds& b) {
    const glm::vec3 side = b.max - b.min;
    return side.x * side.y + side.y * side.z + side.z * side.x;
  }

  /// Half-edges by their lower end.
  struct EdgesAtVertices {
    std::vector<std::uint32_t> begin;  ///< [vertex + 1]
    std::vector<std::uint32_t> edges;
  };
  EdgesAtVertices edges_at_vertices() const {
    EdgesAtVertices at{std::vector<std::uint32_t>(positions_.size() + 2, 0), std::vector<std::uint32_t>(twins_.size())};
    const auto count = static_cast<std::uint32_t>(twins_.size());
    for (std::uint32_t edge = 0; edge < count; ++edge) ++at.begin[ends(edge).low + 2];
    for (std::size_t v = 2; v < at.begin.size(); ++v) at.begin[v] += at.begin[v - 1];
    for (std::uint32_t edge = 0; edge < count; ++edge) at.edges[at.begin[ends(edge).low + 1]++] = edge;
    at.begin.pop_back();
    return at;
  }

  /// Half-edges in opposite directions become twins; where more than two triangles meet at an edge, some of them.
  void match_twins(EdgesAtVertices at) {
    parallel_for(std::size_t{0}, at.begin.size() - 1, [&](std::size_t v) {
      const auto first = at.edges.begin() + at.begin[v], last = at.edges.begin() + at.begin[v + 1];
      const auto key = [&](std::uint32_t edge) {
        const Ends e = ends(edge);
        return std::tuple(e.high, e.upwards, edge);
      };
      std::sort(first, last, [&](std::uint32_t a, std::uint32_t b) { return key(a) < key(b); });
      for (auto edge = first; edge != last;) {
        const std::uint32_t high = ends(*edge).high;
        const auto end = std::find_if(edge, last, [&](std::uint32_t e) { return ends(e).high != high; });
        const auto upwards = std::find_if(edge, end, [&](std::uint32_t e) { return ends(e).upwards; });
        for (auto a = edge, b = upwards; a != upwards && b != end; ++a, ++b) {
          twins_[*a] = *b;
          twins_[*b] = *a;
        }
        edge = end;
      }
    });
  }

  std::span<const std::uint32_t> triangles_;
  std::span<const glm::vec3> positions_;
  std::span<const std::uint32_t> indices_;
  std::vector<std::uint32_t> twins_;
};

/// [triangle of the list] the edge across which it is paired, kNone: alone.
std::vector<std::uint32_t> match(const Neighbours& neighbours, std::uint32_t count) {
  std::vector<std::uint32_t> favourite(count), partner(count, kNone);
  parallel_for(std::uint32_t{0}, count,
               [&](std::uint32_t t) { favourite[t] = neighbours.best_edge(t, [](std::uint32_t) { return true; }); });
  const auto pair = [&](std::uint32_t edge) {
    partner[edge / 3] = edge;
    partner[neighbours.twin(edge) / 3] = neighbours.twin(edge);
  };
  // First the triangles that prefer each other, then neighbours that are left.
  for (std::uint32_t t = 0; t < count; ++t) {
    if (favourite[t] == kNone || partner[t] != kNone) continue;
    if (const std::uint32_t twin = neighbours.twin(favourite[t]); favourite[twin / 3] == twin) pair(favourite[t]);
  }
  for (std::uint32_t t = 0; t < count; ++t) {
    if (partner[t] != kNone) continue;
    const std::uint32_t edge = neighbours.best_edge(t, [&](std::uint32_t other) { return partner[other] == kNone; });
    if (edge != kNone) pair(edge);
  }
  return partner;
}

}  // namespace

TrianglePairs pair_triangles(std::span<const std::uint32_t> triangles, std::span<const glm::vec3> positions,
                             std::span<std::uint32_t> indices) {
  const auto count = static_cast<std::uint32_t>(triangles.size());
  const Neighbours neighbours(triangles, positions, indices);
  const std::vector<std::uint32_t> partner = match(neighbours, count);
  TrianglePairs pairs;
  pairs.order.reserve(count);
  // Rotates the corners so that the shared edge runs from the second corner to the third.
  const auto append = [&](std::uint32_t edge) {
    std::uint32_t* corners = &indices[3 * std::size_t{triangles[edge / 3]}];
    std::rotate(corners, corners + (edge % 3 + 2) % 3, corners + 3);
    pairs.order.push_back(triangles[edge / 3]);
  };
  for (std::uint32_t t = 0; t < count; ++t) {
    if (partner[t] == kNone || neighbours.twin(partner[t]) / 3 < t) continue;
    append(partner[t]);
    append(neighbours.twin(partner[t]));
    ++pairs.pair_count;
  }
  for (std::uint32_t t = 0; t < count; ++t)
    if (partner[t] == kNone) pairs.order.push_back(triangles[t]);
  return pairs;
}

}  // namespace maquette
