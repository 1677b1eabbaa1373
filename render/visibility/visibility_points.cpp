#include "render/visibility/visibility_points.h"

#include <algorithm>
#include <bit>
#include <cassert>
#include <cmath>
#include <numbers>
#include <unordered_map>

#include "render/math/shared_formulas.h"
#include "render/visibility/visibility_bake.h"
#include "scenes/files.h"

namespace maquette {

namespace {

/// Ray origins are inset by this share of the way from a vertex to the centroid of its triangles.
constexpr float kInset = 0.02f;
/// 16 ulp of the coordinates or of the triangle's own size, whichever is larger.
constexpr float kRelativeLift = 1.0f / 262144.0f;
/// The width of one cell of the direction map: a coarser mesh has no smooth horizon.
constexpr float kMaxHorizonSlack = 0.26f;
/// Shortest length that bandwidth resolves, in units of the scene radius.
constexpr double kBandwidthFloor = 1.0 / 16384.0;

bool is_finite(const glm::vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

/// Position and normal, with -0 replaced by 0 for bitwise comparison, and the item.
struct WeldKey {
  std::array<std::uint32_t, 7> words;
  bool operator==(const WeldKey&) const = default;
};

struct WeldHash {
  std::size_t operator()(const WeldKey& key) const {
    std::uint64_t h = 0x9e3779b97f4a7c15ull;
    for (std::uint32_t w : key.words) {
      h = (h ^ w) * 0xff51afd7ed558ccdull;
      h ^= h >> 29;
    }
    return static_cast<std::size_t>(h);
  }
};

WeldKey weld_key(const glm::vec3& p, const glm::vec3& n, std::uint32_t item) {
  const float values[6] = {p.x + 0.0f, p.y + 0.0f, p.z + 0.0f, n.x + 0.0f, n.y + 0.0f, n.z + 0.0f};
  WeldKey key{};
  for (std::size_t i = 0; i < 6; ++i) key.words[i] = std::bit_cast<std::uint32_t>(values[i]);
  key.words[6] = item;
  return key;
}

glm::vec3 unit_or_up(const glm::vec3& n) {
  const glm::dvec3 d(n);
  const double length = glm::length(d);
  return is_finite(n) && length > 1e-30 ? glm::vec3(d / length) : glm::vec3(0.0f, 1.0f, 0.0f);
}

bool is_usable(const FlatGeometry& geometry, const std::uint32_t* corner) {
  for (int k = 0; k < 3; ++k) {
    if (corner[k] >= geometry.positions.size() || !is_finite(geometry.positions[corner[k]])) return false;
  }
  return corner[0] != corner[1] && corner[1] != corner[2] && corner[2] != corner[0];
}

/// Corners of the usable triangles; `item_ends`: number of triangles up to the end of each item.
std::vector<std::array<std::uint32_t, 3>> collect_triangles(const FlatGeometry& geometry,
                                                            std::vector<std::size_t>* item_ends) {
  std::vector<std::array<std::uint32_t, 3>> triangles;
  for (const DrawItem& item : geometry.items) {
    for (std::uint32_t k = 0; k + 2 < item.index_count; k += 3) {
      const std::uint32_t* corner = &geometry.indices[item.first_index + k];
      if (is_usable(geometry, corner)) triangles.push_back({corner[0], corner[1], corner[2]});
    }
    item_ends->push_back(triangles.size());
  }
  return triangles;
}

/// Removes panes, which have visibility but do not occlude.
void drop_transmitting(const std::vector<bool>& transmits, const std::vector<std::size_t>& item_ends,
                       VisibilityPoints* points) {
  std::vector<std::array<std::uint32_t, 3>> kept;
  std::size_t first = 0;
  for (std::size_t i = 0; i < item_ends.size(); ++i) {
    const auto begin = points->triangles.begin();
    if (i >= transmits.size() || !transmits[i])
      kept.insert(kept.end(), begin + static_cast<std::ptrdiff_t>(first),
                  begin + static_cast<std::ptrdiff_t>(item_ends[i]));
    first = item_ends[i];
  }
  points->triangles = std::move(kept);
}

void fit_scale(const FlatGeometry& geometry, VisibilityPoints* points) {
  glm::dvec3 low(1e300);
  glm::dvec3 high(-1e300);
  for (const auto& triangle : points->triangles) {
    for (std::uint32_t vertex : triangle) {
      low = glm::min(low, glm::dvec3(geometry.positions[vertex]));
      high = glm::max(high, glm::dvec3(geometry.positions[vertex]));
    }
  }
  if (points->triangles.empty()) return;
  points->center = 0.5 * (low + high);
  const double radius = 0.5 * glm::length(high - low);
  points->scale_m = radius > 1e-30 ? radius : 1.0;
}

void weld(const FlatGeometry& geometry, const std::vector<std::size_t>& item_ends, VisibilityPoints* points,
          const std::atomic<bool>& cancel) {
  std::unordered_map<WeldKey, std::uint32_t, WeldHash> known;
  known.reserve(geometry.positions.size());
  points->point_of_vertex.assign(geometry.positions.size(), kNoPoint);
  std::uint32_t item = 0;
  for (std::size_t i = 0; i < points->triangles.size(); ++i) {
    if (cancel) return;
    while (i >= item_ends[item]) ++item;
    auto& triangle = points->triangles[i];
    for (std::uint32_t& corner : triangle) {
      std::uint32_t& point = points->point_of_vertex[corner];
      if (point == kNoPoint) {
        const glm::vec3& position = geometry.positions[corner];
        const glm::vec3 normal = corner < geometry.normals.size() ? geometry.normals[corner] : glm::vec3(0.0f);
        const auto next = static_cast<std::uint32_t>(points->points.size());
        const auto [entry, is_new] = known.emplace(weld_key(position, normal, item), next);
        if (is_new) {
          VisibilityPoint made;
          made.position = glm::vec3((glm::dvec3(position) - points->center) / points->scale_m);
          made.normal = unit_or_up(normal);
          points->points.push_back(made);
        }
        point = entry->second;
      }
      corner = point;
    }
  }
}

/// Computes inset, lift and horizon slack from the triangles around each point.
void place_origins(VisibilityPoints* points) {
  struct Fan {
    glm::vec3 middle_sum{0.0f};
    float count = 0.0f;
    float longest = 0.0f;
    float highest = 0.0f;  // of the fan's corners above or below the tangent plane
  };
  std::vector<Fan> fans(points->points.size());
  for (const auto& triangle : points->triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      VisibilityPoint& at = points->points[triangle[k]];
      Fan& fan = fans[triangle[k]];
      glm::vec3 middle(0.0f);
      for (std::size_t j = 1; j < 3; ++j) {
        const VisibilityPoint& other = points->points[triangle[(k + j) % 3]];
        const glm::vec3 edge = other.position - at.position;
        const float height = glm::dot(edge, at.normal);
        middle += edge / 3.0f;
        fan.longest = std::max(fan.longest, glm::length(edge));
        fan.highest = std::max(fan.highest, std::abs(height));
        if (height < 0.0f) {
          const float curvature = glm::length(glm::cross(at.normal, other.normal));
          at.horizon_slack = std::max(at.horizon_slack, std::min(curvature, kMaxHorizonSlack));
        }
      }
      fan.middle_sum += middle;
      fan.count += 1.0f;
    }
  }
  for (std::size_t i = 0; i < fans.size(); ++i) {
    VisibilityPoint& at = points->points[i];
    const Fan& fan = fans[i];
    const glm::vec3 inset = kInset * fan.middle_sum / std::max(fan.count, 1.0f);
    at.inset = inset - at.normal * glm::dot(at.normal, inset);
    const float magnitude = std::max({std::abs(at.position.x), std::abs(at.position.y), std::abs(at.position.z)});
    at.lift = kRelativeLift * std::max(magnitude, fan.longest) + kInset * fan.highest;
  }
}

/// Solid angle of a cell over pi, and its centre. The map projects the sphere to the octahedron |x| + |y| + |z| = 1.
struct CellWeight {
  glm::vec3 direction{};
  double share;
};

std::array<CellWeight, kVisibilitySide * kVisibilitySide> compute_cell_weights() {
  std::array<CellWeight, kVisibilitySide * kVisibilitySide> cells{};
  double total = 0.0;
  for (int b = 0; b < kVisibilitySide * kVisibilitySide; ++b) {
    const glm::vec3 d = shared::visibility_cell_direction(glm::ivec2(b % kVisibilitySide, b / kVisibilitySide));
    // Cells have equal areas on the octahedron at distance r = 1 / (|x| + |y| + |z|) and equal slant: solid angle ~ 1 /
    // r^3.
    const double inverse = std::abs(d.x) + std::abs(d.y) + std::abs(d.z);
    cells[static_cast<std::size_t>(b)] = {d, inverse * inverse * inverse};
    total += cells[static_cast<std::size_t>(b)].share;
  }
  for (CellWeight& cell : cells) cell.share *= 4.0 / total;
  return cells;
}

/// F of compute_visibility_bandwidth, on the sides of +n (x) and -n (y).
glm::dvec2 changed_share(const VisibilityPoint& a, const VisibilityPoint& b, const VisibilityBits& bits_a,
                         const VisibilityBits& bits_b) {
  static const auto kCells = compute_cell_weights();
  glm::dvec2 sides(0.0);
  for (std::size_t word = 0; word < bits_a.size(); ++word) {
    for (std::uint32_t rest = bits_a[word] ^ bits_b[word]; rest != 0; rest &= rest - 1) {
      const CellWeight& cell = kCells[32 * word + static_cast<std::size_t>(std::countr_zero(rest))];
      const float cos_a = glm::dot(a.normal, cell.direction);
      const float cos_b = glm::dot(b.normal, cell.direction);
      if (cos_a * cos_b <= 0.0f) continue;
      sides[cos_a > 0.0f ? 0 : 1] += cell.share * 0.5 * (std::abs(cos_a) + std::abs(cos_b));
    }
  }
  return glm::min(sides, glm::dvec2(1.0));
}

void average_with_neighbours(const VisibilityPoints& points, std::vector<glm::vec2>* values) {
  std::vector<glm::vec3> sums(values->size(), glm::vec3(0.0f));  // z: number of terms
  for (const auto& triangle : points.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::vec2 others = (*values)[triangle[(k + 1) % 3]] + (*values)[triangle[(k + 2) % 3]];
      sums[triangle[k]] += glm::vec3(others, 2.0f);
    }
  }
  for (std::size_t i = 0; i < values->size(); ++i) {
    if (sums[i].z > 0.0f) (*values)[i] = 0.5f * (*values)[i] + 0.5f * glm::vec2(sums[i]) / sums[i].z;
  }
}

}  // namespace

VisibilityPoints build_visibility_points(const FlatGeometry& geometry, const std::vector<bool>& transmits,
                                         const std::atomic<bool>& cancel) {
  assert(transmits.size() == geometry.items.size());
  VisibilityPoints points;
  std::vector<std::size_t> item_ends;
  points.triangles = collect_triangles(geometry, &item_ends);
  if (cancel) return points;
  fit_scale(geometry, &points);
  weld(geometry, item_ends, &points, cancel);
  if (cancel) return points;
  place_origins(&points);
  drop_transmitting(transmits, item_ends, &points);
  return points;
}

std::vector<float> compute_visibility_bandwidth(const VisibilityPoints& points,
                                                const std::vector<VisibilityBits>& bits) {
  const std::size_t count = points.points.size();
  std::vector<glm::dvec2> change(count, glm::dvec2(0.0));
  std::vector<double> length(count, 0.0);
  for (const auto& triangle : points.triangles) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::uint32_t a = triangle[k];
      const std::uint32_t b = triangle[(k + 1) % 3];
      const double edge = glm::length(points.points[a].position - points.points[b].position) + kBandwidthFloor;
      const glm::dvec2 changed = changed_share(points.points[a], points.points[b], bits[a], bits[b]);
      change[a] += changed;
      change[b] += changed;
      length[a] += edge;
      length[b] += edge;
    }
  }
  std::vector<glm::vec2> sides(count, glm::vec2(0.0f));
  for (std::size_t i = 0; i < count; ++i) {
    if (length[i] > 0.0) sides[i] = glm::vec2(0.25 * std::numbers::pi * change[i] / (length[i] * points.scale_m));
  }
  for (int round = 0; round < 2; ++round) average_with_neighbours(points, &sides);
  std::vector<float> bandwidth(count);
  std::transform(sides.begin(), sides.end(), bandwidth.begin(), [](const glm::vec2& s) { return std::max(s.x, s.y); });
  return bandwidth;
}

}  // namespace maquette
