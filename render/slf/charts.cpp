#include "render/slf/charts.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <map>
#include <numeric>
#include <unordered_map>

namespace maquette {

namespace {

/// Charts end where neighbouring normals differ by more: a bilinear read would blend two faces of an edge.
const double kSmoothEdge = std::cos(0.45);
/// Cone of a chart's normals while it grows, and at the end; the projection stretches by at most 1 / cos of that.
constexpr double kGrowingCone = 0.75, kLargestCone = 1.1;  // rad
constexpr int kOverlapRaster = 1024;
/// Cells that may be covered twice by rounding.
constexpr double kOverlapTolerated = 5e-4;

std::uint64_t hash_of(const glm::dvec3& p) {
  const glm::vec3 f(p);
  std::uint32_t bits[3];
  std::memcpy(bits, &f, sizeof bits);
  std::uint64_t h = 0x9e3779b97f4a7c15ull;
  for (std::uint32_t b : bits) h = (h ^ b) * 0xff51afd7ed558ccdull, h ^= h >> 32;
  return h;
}

/// Neighbours of each triangle over edges across which normals are continuous. [triangle][edge], -1: none.
std::vector<std::array<int, 3>> find_neighbours(const std::vector<ChartTriangle>& triangles) {
  struct Edge {
    std::uint64_t a, b;
    int triangle, edge;
    bool operator<(const Edge& o) const { return std::tie(a, b, triangle) < std::tie(o.a, o.b, o.triangle); }
  };
  std::vector<Edge> edges;
  edges.reserve(3 * triangles.size());
  for (std::size_t t = 0; t < triangles.size(); ++t)
    for (std::size_t e = 0; e < 3; ++e) {
      const std::uint64_t a = hash_of(triangles[t].corners[e]), b = hash_of(triangles[t].corners[(e + 1) % 3]);
      edges.push_back({std::min(a, b), std::max(a, b), static_cast<int>(t), static_cast<int>(e)});
    }
  std::sort(edges.begin(), edges.end());
  std::vector<std::array<int, 3>> neighbours(triangles.size(), {-1, -1, -1});
  for (std::size_t i = 0, j = 0; i < edges.size(); i = j) {
    for (j = i + 1; j < edges.size() && edges[j].a == edges[i].a && edges[j].b == edges[i].b;) ++j;
    if (j - i != 2) continue;  // a border, or more than two meet there
    const ChartTriangle &p = triangles[static_cast<std::size_t>(edges[i].triangle)],
                        &q = triangles[static_cast<std::size_t>(edges[i + 1].triangle)];
    bool smooth = true;
    for (int end = 0; end < 2; ++end) {
      const auto k = static_cast<std::size_t>((edges[i].edge + end) % 3);
      for (std::size_t m = 0; m < 3; ++m)
        if (p.corners[k] == q.corners[m]) smooth &= glm::dot(p.normals[k], q.normals[m]) > kSmoothEdge;
    }
    if (!smooth) continue;
    neighbours[static_cast<std::size_t>(edges[i].triangle)][static_cast<std::size_t>(edges[i].edge)] =
        edges[i + 1].triangle;
    neighbours[static_cast<std::size_t>(edges[i + 1].triangle)][static_cast<std::size_t>(edges[i + 1].edge)] =
        edges[i].triangle;
  }
  return neighbours;
}

glm::dvec3 any_across(const glm::dvec3& n) {
  const glm::dvec3 axis = std::abs(n.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 0, 1);
  return glm::normalize(glm::cross(n, axis));
}

glm::dvec2 turned(const glm::dvec2& p, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * p.x + s * p.y, -s * p.x + c * p.y};
}

/// Turns plane coordinates to their main direction where that makes their box smaller, and moves them to start at 0.
void settle(std::vector<std::array<glm::dvec2, 3>>* at, glm::dvec2* extent) {
  glm::dvec2 mean(0.0);
  for (const auto& t : *at) mean += (t[0] + t[1] + t[2]) / 3.0;
  mean /= static_cast<double>(std::max<std::size_t>(at->size(), 1));
  double xx = 0.0, xy = 0.0, yy = 0.0;
  for (const auto& t : *at)
    for (const glm::dvec2& p : t) {
      const glm::dvec2 d = p - mean;
      xx += d.x * d.x, xy += d.x * d.y, yy += d.y * d.y;
    }
  double best = 0.0;
  std::array<glm::dvec2, 2> box{};
  for (const double angle : {0.0, 0.5 * std::atan2(2.0 * xy, xx - yy)}) {
    glm::dvec2 low(1e300), high(-1e300);
    for (const auto& t : *at)
      for (const glm::dvec2& p : t) low = glm::min(low, turned(p, angle)), high = glm::max(high, turned(p, angle));
    const glm::dvec2 size = high - low;
    if (angle != 0.0 && size.x * size.y > 0.95 * extent->x * extent->y) break;
    best = angle;
    box = {low, high};
    *extent = size;
  }
  for (auto& t : *at)
    for (glm::dvec2& p : t) p = turned(p, best) - box[0];
}

glm::dvec3 mean_normal(const std::vector<ChartTriangle>& all, const std::vector<int>& members) {
  glm::dvec3 sum(0.0);
  for (int i : members) {
    const ChartTriangle& t = all[static_cast<std::size_t>(i)];
    sum += t.area * t.normal;
  }
  const double length = glm::length(sum);
  return length > 1e-30 ? sum / length : all[static_cast<std::size_t>(members.front())].normal;
}

Chart make_chart(const std::vector<ChartTriangle>& all, const std::vector<int>& members,
                 std::vector<std::array<glm::dvec2, 3>> at) {
  Chart chart;
  settle(&at, &chart.extent);
  chart.axis = mean_normal(all, members);
  for (std::size_t i = 0; i < members.size(); ++i) {
    const ChartTriangle& t = all[static_cast<std::size_t>(members[i])];
    AtlasSide side{t.triangle, t.back, 0, {}, t.vertices};
    for (std::size_t k = 0; k < 3; ++k) side.at[k] = glm::vec2(at[i][k]);
    chart.sides.push_back(side);
  }
  return chart;
}

std::vector<std::array<glm::dvec2, 3>> project(const std::vector<ChartTriangle>& all, const std::vector<int>& members,
                                               const glm::dvec3& axis) {
  const glm::dvec3 x = any_across(axis), y = glm::cross(axis, x);
  std::vector<std::array<glm::dvec2, 3>> at;
  for (int i : members) {
    std::array<glm::dvec2, 3> corners{};
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::dvec3& p = all[static_cast<std::size_t>(i)].corners[k];
      corners[k] = {glm::dot(p, x), glm::dot(p, y)};
    }
    at.push_back(corners);
  }
  return at;
}

/// Grows charts over triangles of which `owner` says that nobody has them (-1).
class Grower {
 public:
  explicit Grower(const std::vector<ChartTriangle>& triangles)
      : all_(triangles), neighbours_(find_neighbours(triangles)), owner_(triangles.size(), -1) {}

  std::vector<std::vector<int>> grow() {
    std::vector<int> order(all_.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return area(a) > area(b); });
    for (int seed : order)
      if (owner(seed) < 0) start(seed, kGrowingCone);
    merge_small();
    std::vector<std::vector<int>> kept;
    for (std::size_t i = 0; i < charts_.size(); ++i) add_without_overlap(std::move(charts_[i]), kGrowingCone, &kept);
    return kept;
  }

 private:
  int& owner(int t) { return owner_[static_cast<std::size_t>(t)]; }
  double area(int t) const { return all_[static_cast<std::size_t>(t)].area; }
  const glm::dvec3& normal(int t) const { return all_[static_cast<std::size_t>(t)].normal; }

  void start(int seed, double cone) {
    const int id = static_cast<int>(charts_.size());
    std::vector<int> members{seed};
    owner(seed) = id;
    glm::dvec3 sum = area(seed) * normal(seed);
    for (std::size_t next = 0; next < members.size(); ++next)
      for (int n : neighbours_[static_cast<std::size_t>(members[next])]) {
        if (n < 0 || owner(n) >= 0 || glm::dot(glm::normalize(sum), normal(n)) < std::cos(cone)) continue;
        owner(n) = id;
        members.push_back(n);
        sum += area(n) * normal(n);
      }
    charts_.push_back(std::move(members));
  }

  bool within_cone(const std::vector<int>& members, const glm::dvec3& axis) const {
    return std::all_of(members.begin(), members.end(),
                       [&](int t) { return glm::dot(axis, normal(t)) > std::cos(kLargestCone); });
  }

  /// Joins charts to a neighbour as long as both fit a cone: fewer seams, and fewer gutters.
  void merge_small() {
    std::vector<int> order(charts_.size());
    std::iota(order.begin(), order.end(), 0);
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) {
      return charts_[static_cast<std::size_t>(a)].size() < charts_[static_cast<std::size_t>(b)].size();
    });
    for (int id : order) {
      std::vector<int>& own = charts_[static_cast<std::size_t>(id)];
      std::map<int, int> borders;
      for (int t : own)
        for (int n : neighbours_[static_cast<std::size_t>(t)])
          if (n >= 0 && owner(n) != id) ++borders[owner(n)];
      std::vector<std::pair<int, int>> by_length(borders.begin(), borders.end());
      std::stable_sort(by_length.begin(), by_length.end(),
                       [](const auto& a, const auto& b) { return a.second > b.second; });
      for (const auto& [other, length] : by_length)
        if (join(id, other)) break;
    }
    std::erase_if(charts_, [](const std::vector<int>& chart) { return chart.empty(); });
  }

  bool join(int id, int other) {
    std::vector<int>&own = charts_[static_cast<std::size_t>(id)], &into = charts_[static_cast<std::size_t>(other)];
    std::vector<int> both = into;
    both.insert(both.end(), own.begin(), own.end());
    const glm::dvec3 axis = mean_normal(all_, both);
    if (!within_cone(both, axis) || overlaps_itself(project(all_, both, axis))) return false;
    for (int t : own) owner(t) = other;
    own.clear();
    into = std::move(both);
    return true;
  }

  /// Divides a chart that overlaps itself, or leaves its cone, by growing it again within narrower cones.
  void add_without_overlap(std::vector<int> members, double cone, std::vector<std::vector<int>>* kept) {
    const glm::dvec3 axis = mean_normal(all_, members);
    if (members.size() == 1 || (within_cone(members, axis) && !overlaps_itself(project(all_, members, axis)))) {
      kept->push_back(std::move(members));
      return;
    }
    if (cone < 0.02) {  // a flat part that covers itself
      for (int t : members) kept->push_back({t});
      return;
    }
    for (int t : members) owner(t) = -1;
    const std::size_t before = charts_.size();
    for (int t : members)
      if (owner(t) < 0) start(t, 0.5 * cone);
    std::vector<std::vector<int>> parts(std::make_move_iterator(charts_.begin() + static_cast<std::ptrdiff_t>(before)),
                                        std::make_move_iterator(charts_.end()));
    charts_.resize(before);
    for (std::vector<int>& part : parts) add_without_overlap(std::move(part), 0.5 * cone, kept);
  }

  const std::vector<ChartTriangle>& all_;
  std::vector<std::array<int, 3>> neighbours_;
  std::vector<int> owner_;
  std::vector<std::vector<int>> charts_;
};

double area_of(const std::array<glm::dvec2, 3>& t) {
  const glm::dvec2 a = t[1] - t[0], b = t[2] - t[0];
  return 0.5 * (a.x * b.y - a.y * b.x);
}

}  // namespace

std::vector<ChartTriangle> chart_triangles(const FlatGeometry& g, const DrawItem& item, bool back) {
  std::vector<ChartTriangle> triangles;
  for (std::uint32_t i = item.first_index; i + 2 < item.first_index + item.index_count; i += 3) {
    ChartTriangle t;
    t.triangle = i / 3;
    t.back = back;
    bool finite = true;
    for (std::uint32_t k = 0; k < 3; ++k) {
      const std::uint32_t v = t.vertices[k] = g.indices[i + k];
      t.corners[k] = glm::dvec3(g.positions[v]);
      t.normals[k] = (back ? -1.0 : 1.0) * glm::dvec3(g.normals[v]);
      for (int c = 0; c < 3; ++c) finite &= std::isfinite(t.corners[k][c]) && std::isfinite(t.normals[k][c]);
    }
    const glm::dvec3 across = glm::cross(t.corners[1] - t.corners[0], t.corners[2] - t.corners[0]);
    t.area = 0.5 * glm::length(across);
    if (!finite || !(t.area > 1e-20)) continue;
    t.normal = across / (2.0 * t.area) * (back ? -1.0 : 1.0);
    triangles.push_back(t);
  }
  return triangles;
}

bool overlaps_itself(const std::vector<std::array<glm::dvec2, 3>>& triangles) {
  glm::dvec2 low(1e300), high(-1e300);
  for (const auto& t : triangles)
    for (const glm::dvec2& p : t) low = glm::min(low, p), high = glm::max(high, p);
  const double extent = std::max(high.x - low.x, high.y - low.y);
  if (!(extent > 0.0)) return false;
  const int side = static_cast<int>(
      std::clamp(8.0 * std::sqrt(static_cast<double>(triangles.size())), 32.0, double{kOverlapRaster}));
  const double scale = side / extent;
  std::vector<std::uint8_t> seen(static_cast<std::size_t>(side * side), 0);
  std::size_t covered = 0, twice = 0;
  for (const auto& t : triangles) {
    const double area = area_of(t);
    if (area == 0.0) continue;
    const glm::dvec2 a = (glm::min(glm::min(t[0], t[1]), t[2]) - low) * scale,
                     b = (glm::max(glm::max(t[0], t[1]), t[2]) - low) * scale;
    for (int y = std::max(0, static_cast<int>(a.y)); y <= std::min(side - 1, static_cast<int>(b.y)); ++y)
      for (int x = std::max(0, static_cast<int>(a.x)); x <= std::min(side - 1, static_cast<int>(b.x)); ++x) {
        const glm::dvec2 p = low + glm::dvec2(x + 0.5, y + 0.5) / scale;
        const double u = area_of({p, t[1], t[2]}) / area, v = area_of({t[0], p, t[2]}) / area;
        if (u < 1e-6 || v < 1e-6 || u + v > 1.0 - 1e-6) continue;
        std::uint8_t& cell = seen[static_cast<std::size_t>(y * side + x)];
        covered += cell == 0 ? 1 : 0;
        twice += cell == 1 ? 1 : 0;
        cell = static_cast<std::uint8_t>(std::min(cell + 1, 2));
      }
  }
  return static_cast<double>(twice) > kOverlapTolerated * static_cast<double>(covered) + 0.5;
}

std::vector<Chart> charts_of_uvs(const FlatGeometry& g, const std::vector<ChartTriangle>& triangles) {
  const auto uv = [&](int t, std::size_t k) {
    const std::uint32_t triangle = triangles[static_cast<std::size_t>(t)].triangle;
    return glm::dvec2(g.uv1[g.indices[3 * static_cast<std::size_t>(triangle) + k]]);
  };
  const std::vector<std::array<int, 3>> neighbours = find_neighbours(triangles);
  std::vector<bool> taken(triangles.size(), false);
  const auto continues = [&](int a, int b) {  // they share an edge of the surface; of the UV set too?
    int shared = 0;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j)
        shared +=
            triangles[static_cast<std::size_t>(a)].corners[i] == triangles[static_cast<std::size_t>(b)].corners[j] &&
                    glm::length(uv(a, i) - uv(b, j)) < 1e-6
                ? 1
                : 0;
    return shared >= 2;
  };
  std::vector<Chart> charts;
  for (int seed = 0; seed < static_cast<int>(triangles.size()); ++seed) {
    if (taken[static_cast<std::size_t>(seed)]) continue;
    std::vector<int> members{seed};
    taken[static_cast<std::size_t>(seed)] = true;
    for (std::size_t next = 0; next < members.size(); ++next)
      for (int n : neighbours[static_cast<std::size_t>(members[next])]) {
        if (n < 0 || taken[static_cast<std::size_t>(n)] || !continues(members[next], n)) continue;
        taken[static_cast<std::size_t>(n)] = true;
        members.push_back(n);
      }
    std::vector<std::array<glm::dvec2, 3>> at;
    double flat = 0.0, area = 0.0;
    for (int t : members) {
      at.push_back({uv(t, 0), uv(t, 1), uv(t, 2)});
      flat += std::abs(area_of(at.back()));
      area += triangles[static_cast<std::size_t>(t)].area;
    }
    const double scale = std::sqrt(area / std::max(flat, 1e-30));
    for (auto& t : at)
      for (glm::dvec2& p : t) p *= scale;
    charts.push_back(make_chart(triangles, members, std::move(at)));
  }
  return charts;
}

std::vector<Chart> charts_of_cones(const std::vector<ChartTriangle>& triangles) {
  std::vector<Chart> charts;
  for (const std::vector<int>& members : Grower(triangles).grow())
    charts.push_back(make_chart(triangles, members, project(triangles, members, mean_normal(triangles, members))));
  return charts;
}

}  // namespace maquette
