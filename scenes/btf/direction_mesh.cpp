#include "scenes/btf/direction_mesh.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <numbers>
#include <numeric>
#include <set>

namespace maquette {

namespace {

constexpr int kGridSide = 64;
/// Four directions on one circle (all of a ring) have two triangulations: radii that differ by parts of this decide.
/// Far below what moves an edge between directions 0.1 degrees apart, far above rounding.
constexpr double kPerturbation = 1e-9;

double perturbed_radius(std::size_t i) {
  // A hash in [0, 1): neighbours must differ.
  std::uint32_t h = static_cast<std::uint32_t>(i) * 2654435761u;
  h ^= h >> 15;
  h *= 2246822519u;
  h ^= h >> 13;
  return 1.0 + kPerturbation * (static_cast<double>(h) / 4294967296.0);
}

double volume(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, const glm::dvec3& d) {
  return glm::dot(glm::cross(b - a, c - a), d - a);
}

/// Convex hull by adding points one after the other: O(n^2) for the few hundred directions of a measurement.
class Hull {
 public:
  explicit Hull(std::vector<glm::dvec3> points) : points_(std::move(points)) {}

  /// Outward triangles; none when all points lie in a plane.
  std::vector<std::array<int, 3>> build() {
    if (!start()) return {};
    for (int i = 0; i < static_cast<int>(points_.size()); ++i)
      if (std::find(first_.begin(), first_.end(), i) == first_.end()) add(i);
    return faces_;
  }

 private:
  const glm::dvec3& at(int i) const { return points_[static_cast<std::size_t>(i)]; }

  template <typename Size>
  int largest(const Size& size) const {
    int best = 0;
    for (int i = 1; i < static_cast<int>(points_.size()); ++i)
      if (size(at(i)) > size(at(best))) best = i;
    return best;
  }

  bool start() {
    constexpr double kFlat = 1e-7;
    const int a = 0;
    const int b = largest([&](const glm::dvec3& p) { return glm::length(p - at(a)); });
    const int c = largest([&](const glm::dvec3& p) { return glm::length(glm::cross(at(b) - at(a), p - at(a))); });
    const int d = largest([&](const glm::dvec3& p) { return std::abs(volume(at(a), at(b), at(c), p)); });
    const double size = volume(at(a), at(b), at(c), at(d));
    if (std::abs(size) < kFlat * kFlat) return false;
    first_ = {a, b, c, d};
    if (size > 0.0) std::swap(first_[1], first_[2]);
    const auto [p, q, r, s] = first_;
    faces_ = {{p, q, r}, {p, s, q}, {q, s, r}, {r, s, p}};
    return true;
  }

  void add(int point) {
    std::set<std::pair<int, int>> edges;
    std::vector<std::array<int, 3>> kept;
    for (const std::array<int, 3>& f : faces_) {
      if (volume(at(f[0]), at(f[1]), at(f[2]), at(point)) <= 0.0) {
        kept.push_back(f);
        continue;
      }
      for (std::size_t k = 0; k < 3; ++k) {
        const int from = f[k], to = f[(k + 1) % 3];
        if (edges.erase({to, from}) == 0) edges.insert({from, to});
      }
    }
    for (const auto& [from, to] : edges) kept.push_back({from, to, point});
    faces_ = std::move(kept);
  }

  std::vector<glm::dvec3> points_;
  std::array<int, 4> first_{};
  std::vector<std::array<int, 3>> faces_;
};

DirectionWeights make_weights(int a, int b, int c, const glm::vec3& weight) {
  const glm::vec3 positive = glm::max(weight, glm::vec3(0.0f));
  return {{a, b, c}, positive / (positive.x + positive.y + positive.z)};
}

}  // namespace

DirectionMesh::DirectionMesh(std::vector<glm::dvec3> directions) : directions_(std::move(directions)) {
  if (directions_.size() < 2) return;
  triangulate();
  if (triangles_.empty())
    order_great_circle();
  else
    build_grid();
}

/// The hull of the directions and of the origin: its faces without the origin cover the cone that the directions span,
/// and the edges of those with the origin are its border.
void DirectionMesh::triangulate() {
  std::vector<glm::dvec3> points;
  for (std::size_t i = 0; i < directions_.size(); ++i) points.push_back(directions_[i] * perturbed_radius(i));
  const int origin = static_cast<int>(points.size());
  points.emplace_back(0.0);
  std::map<std::pair<int, int>, int> edges;  // of the triangles: the triangle to its left
  for (const std::array<int, 3>& face : Hull(std::move(points)).build()) {
    if (std::find(face.begin(), face.end(), origin) != face.end()) continue;
    for (std::size_t k = 0; k < 3; ++k) edges[{face[k], face[(k + 1) % 3]}] = static_cast<int>(triangles_.size());
    triangles_.push_back(face);
  }
  for (const std::array<int, 3>& t : triangles_) {
    std::array<int, 3> across{};
    for (std::size_t k = 0; k < 3; ++k) {
      const int from = t[(k + 1) % 3], to = t[(k + 2) % 3];
      const auto found = edges.find({to, from});
      across[k] = found == edges.end() ? -1 : found->second;
      if (across[k] < 0) border_.push_back({from, to});
    }
    neighbours_.push_back(across);
    const auto corner = [&](std::size_t k) { return directions_[static_cast<std::size_t>(t[k])]; };
    inverses_.emplace_back(glm::inverse(glm::dmat3(corner(0), corner(1), corner(2))));
  }
}

/// All directions in one plane with the origin: a chain of arcs.
void DirectionMesh::order_great_circle() {
  std::size_t far = 1;
  for (std::size_t i = 1; i < directions_.size(); ++i)
    if (glm::dot(directions_[i], directions_[0]) < glm::dot(directions_[far], directions_[0])) far = i;
  const glm::dvec3 normal = glm::normalize(glm::cross(directions_[0], directions_[far]));
  const glm::dvec3 across = glm::cross(normal, directions_[0]);
  std::vector<int> order(directions_.size());
  std::iota(order.begin(), order.end(), 0);
  const auto angle = [&](int i) {
    const glm::dvec3& d = directions_[static_cast<std::size_t>(i)];
    return std::atan2(glm::dot(d, across), glm::dot(d, directions_[0]));
  };
  std::sort(order.begin(), order.end(), [&](int a, int b) { return angle(a) < angle(b); });
  for (std::size_t i = 1; i < order.size(); ++i) border_.push_back({order[i - 1], order[i]});
}

void DirectionMesh::build_grid() {
  grid_.assign(kGridSide * kGridSide, 0);
  for (int y = 0; y < kGridSide; ++y)
    for (int x = 0; x < kGridSide; ++x) {
      glm::vec2 p = (glm::vec2(x, y) + 0.5f) * (2.0f / kGridSide) - 1.0f;
      if (glm::length(p) > 0.9999f) p *= 0.9999f / glm::length(p);
      const glm::vec3 d(p, std::sqrt(1.0f - glm::dot(p, p)));
      float best = -std::numeric_limits<float>::infinity();
      for (std::size_t t = 0; t < triangles_.size(); ++t) {
        const glm::vec3 w = inverses_[t] * d;
        const float least = std::min({w.x, w.y, w.z});
        if (least <= best) continue;
        best = least;
        grid_[static_cast<std::size_t>(y * kGridSide + x)] = static_cast<std::int32_t>(t);
      }
    }
}

int DirectionMesh::walk(int start, const glm::vec3& direction, glm::vec3* weights) const {
  constexpr float kInside = -1e-6f;
  int t = start;
  for (std::size_t step = 0; step <= triangles_.size(); ++step) {
    const auto i = static_cast<std::size_t>(t);
    *weights = inverses_[i] * direction;
    const int k = weights->x < weights->y ? (weights->x < weights->z ? 0 : 2) : (weights->y < weights->z ? 1 : 2);
    if ((*weights)[k] >= kInside) return t;
    t = neighbours_[i][static_cast<std::size_t>(k)];
    if (t < 0) return -1;
  }
  return -1;
}

DirectionWeights DirectionMesh::find(const glm::vec3& direction) const {
  if (directions_.size() < 2) return {};
  if (triangles_.empty()) return nearest_on_border(direction);
  const auto cell = [](float v) {
    return std::clamp(static_cast<int>((v * 0.5f + 0.5f) * kGridSide), 0, kGridSide - 1);
  };
  const int start = grid_[static_cast<std::size_t>(cell(direction.y) * kGridSide + cell(direction.x))];
  glm::vec3 weights{};
  const int t = walk(start, direction, &weights);
  if (t < 0) return nearest_on_border(direction);
  const std::array<int, 3>& corners = triangles_[static_cast<std::size_t>(t)];
  return make_weights(corners[0], corners[1], corners[2], weights);
}

DirectionWeights DirectionMesh::nearest_on_border(const glm::vec3& direction) const {
  const glm::dvec3 d(direction);
  DirectionWeights best;
  double nearest = -2.0;  // cosine of the angle
  for (const std::array<int, 2>& edge : border_) {
    const glm::dvec3& a = directions_[static_cast<std::size_t>(edge[0])];
    const glm::dvec3& b = directions_[static_cast<std::size_t>(edge[1])];
    const glm::dvec3 normal = glm::normalize(glm::cross(a, b));
    const glm::dvec3 on_circle = d - normal * glm::dot(normal, d);
    // on_circle = s a + t b
    const double s = glm::dot(glm::cross(on_circle, b), normal), t = glm::dot(glm::cross(a, on_circle), normal);
    const double from_a = s > 0.0 && t > 0.0 ? t / (s + t) : glm::dot(d, a) >= glm::dot(d, b) ? 0.0 : 1.0;
    const double cosine = glm::dot(d, glm::normalize(glm::mix(a, b, from_a)));
    if (cosine <= nearest) continue;
    nearest = cosine;
    best = {{edge[0], edge[1], edge[0]}, glm::vec3(1.0 - from_a, from_a, 0.0)};
  }
  return best;
}

DirectionMesh::Quadrature DirectionMesh::quadrature() const {
  // Equal areas on a spiral. Source: Gonzalez 2010, "Measurement of Areas on a Sphere Using Fibonacci and
  // Latitude-Longitude Lattices".
  constexpr int kPoints = 1 << 15;
  constexpr double kTurn = std::numbers::pi * (3.0 - 2.2360679774997896);
  Quadrature q{std::vector<double>(size(), 0.0), std::vector<double>(size(), 0.0)};
  const double area = 2.0 * std::numbers::pi / kPoints;
  for (int i = 0; i < kPoints; ++i) {
    const double z = (i + 0.5) / kPoints, r = std::sqrt(1.0 - z * z);
    const DirectionWeights w = find(glm::vec3(r * std::cos(kTurn * i), r * std::sin(kTurn * i), z));
    for (std::size_t k = 0; k < 3; ++k) {
      const double share = area * static_cast<double>(w.weight[static_cast<int>(k)]);
      q.solid_angle[static_cast<std::size_t>(w.index[k])] += share;
      q.projected[static_cast<std::size_t>(w.index[k])] += share * z;
    }
  }
  return q;
}

glm::dvec3 direction_of_angles(double theta_deg, double phi_deg) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  const double theta = theta_deg * kDegree, phi = phi_deg * kDegree;
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

std::vector<glm::dvec3> ubo_directions() {
  // Source: Sattler et al. 2003, "Efficient and Realistic Visualization of Cloth", Table 1.
  constexpr std::array kCounts = {1, 6, 12, 18, 20, 24};
  std::vector<glm::dvec3> directions;
  for (std::size_t ring = 0; ring < kCounts.size(); ++ring)
    for (int i = 0; i < kCounts[ring]; ++i)
      directions.push_back(direction_of_angles(15.0 * static_cast<double>(ring), 360.0 * i / kCounts[ring]));
  return directions;
}

}  // namespace maquette
