#include "render/bezier/reflector_patch.h"

#include <algorithm>
#include <cmath>

namespace maquette {

namespace {

using bezier_double::bezier_jet;
using bezier_double::SurfaceJet;

/// Converts Bernstein form to powers of x = 2 u - 1.
std::array<glm::dvec3, 4> centred_powers(const std::array<glm::dvec3, 4>& b) {
  return {(b[0] + 3.0 * b[1] + 3.0 * b[2] + b[3]) / 8.0, 3.0 * (b[3] + b[2] - b[1] - b[0]) / 8.0,
          3.0 * (b[0] - b[1] - b[2] + b[3]) / 8.0, (b[3] - 3.0 * b[2] + 3.0 * b[1] - b[0]) / 8.0};
}

glm::dvec2 grid_parameter(int i, int j, int side) { return {-1.0 + 2.0 * i / (side - 1), -1.0 + 2.0 * j / (side - 1)}; }

/// Nonzero for a convex patch: all points of a grid lie on the same side of every tangent plane of the grid.
double find_convex_side(const bezier_double::BezierSurface& s, double size) {
  constexpr int kGrid = 9;
  std::vector<SurfaceJet> jets;
  for (int j = 0; j < kGrid; ++j)
    for (int i = 0; i < kGrid; ++i) jets.push_back(bezier_jet(s, grid_parameter(i, j, kGrid)));
  double above = 0.0, below = 0.0;
  for (const SurfaceJet& at : jets) {
    const glm::dvec3 normal = glm::cross(at.dx, at.dy);
    const double area = glm::length(normal);
    if (area <= 1e-12 * size * size) return 0.0;
    for (const SurfaceJet& other : jets) {
      const double height = glm::dot(other.p - at.p, normal) / area;
      above = std::max(above, height);
      below = std::max(below, -height);
    }
  }
  const double tolerance = 1e-9 * size;
  if (above <= tolerance && below > tolerance) return 1.0;
  if (below <= tolerance && above > tolerance) return -1.0;
  return 0.0;
}

bool is_flat(const std::array<glm::dvec3, 16>& points, const glm::dvec3& origin, const glm::dvec3& normal,
             double size) {
  return std::all_of(points.begin(), points.end(),
                     [&](const glm::dvec3& p) { return std::abs(glm::dot(p - origin, normal)) <= 1e-6 * size; });
}

}  // namespace

ReflectorPatch make_reflector_patch(const std::array<glm::dvec3, 16>& points) {
  ReflectorPatch out;
  std::array<std::array<glm::dvec3, 4>, 4> rows{};
  for (std::size_t j = 0; j < 4; ++j)
    rows[j] = centred_powers({points[4 * j], points[4 * j + 1], points[4 * j + 2], points[4 * j + 3]});
  for (std::size_t i = 0; i < 4; ++i) {
    const std::array<glm::dvec3, 4> column = centred_powers({rows[0][i], rows[1][i], rows[2][i], rows[3][i]});
    for (std::size_t j = 0; j < 4; ++j) out.exact.c[4 * j + i] = column[j];
  }
  out.origin = glm::dvec3(glm::vec3(out.exact.c[0]));  // a float value: objects are moved by it without rounding
  out.exact.c[0] -= out.origin;
  double size = 0.0;
  for (const glm::dvec3& p : points) size = std::max(size, glm::length(p - out.origin));
  double area = 0.0;
  glm::dvec3 normal(0.0);
  for (int j = 0; j < 5; ++j)
    for (int i = 0; i < 5; ++i) {
      const SurfaceJet jet = bezier_jet(out.exact, grid_parameter(i, j, 5));
      const glm::dvec3 n = glm::cross(jet.dx, jet.dy);
      normal += n;
      area = std::max(area, glm::length(n));
    }
  for (std::size_t k = 0; k < 16; ++k) out.single.c[k] = glm::vec3(out.exact.c[k]);
  out.degenerate = !(area > 1e-10 * size * size);
  if (out.degenerate) return out;
  const double length = glm::length(normal);
  out.flat = length > 0.0 && is_flat(points, out.origin + out.exact.c[0], normal / length, size);
  out.convex_side = find_convex_side(out.exact, size);
  return out;
}

std::array<glm::dvec3, 16> part_of_patch(const std::array<glm::dvec3, 16>& points, const glm::dvec4& within) {
  const auto cut = [](const std::array<glm::dvec3, 4>& b, double low, double high) {
    // Blossom (polar form) at (low, low, low), (low, low, high), ...: one step of de Casteljau per argument.
    const auto polar = [&](double r, double s, double t) {
      const glm::dvec3 a0 = glm::mix(b[0], b[1], r), a1 = glm::mix(b[1], b[2], r), a2 = glm::mix(b[2], b[3], r);
      return glm::mix(glm::mix(a0, a1, s), glm::mix(a1, a2, s), t);
    };
    return std::array{polar(low, low, low), polar(low, low, high), polar(low, high, high), polar(high, high, high)};
  };
  const glm::dvec4 u = 0.5 * within + 0.5;
  std::array<glm::dvec3, 16> rows{}, out{};
  for (std::size_t j = 0; j < 4; ++j) {
    const auto row = cut({points[4 * j], points[4 * j + 1], points[4 * j + 2], points[4 * j + 3]}, u.x, u.z);
    std::copy(row.begin(), row.end(), rows.begin() + static_cast<std::ptrdiff_t>(4 * j));
  }
  for (std::size_t i = 0; i < 4; ++i) {
    const auto column = cut({rows[i], rows[4 + i], rows[8 + i], rows[12 + i]}, u.y, u.w);
    for (std::size_t j = 0; j < 4; ++j) out[4 * j + i] = column[j];
  }
  return out;
}

PatchRecord make_patch_record(const ReflectorPatch& patch) {
  PatchRecord record;
  record.origin = glm::vec4(glm::vec3(patch.origin), 1.0f);
  for (std::size_t k = 0; k < 16; ++k) record.coefficients[k] = glm::vec4(patch.single.c[k], 0.0f);
  return record;
}

std::vector<ReflectorNodes> make_reflector_nodes(const ReflectorPatch& patch, const glm::dvec3& eye) {
  constexpr double kEdgeOn = 0.1;  // cosine below which the neighbourhood of a node may be back-facing
  std::vector<ReflectorNodes> sides;
  std::vector<bezier_float::BezierNode> nodes;
  bool careful = false, seen[2] = {false, false};
  for (int j = 0; j < kNodesPerSide; ++j)
    for (int i = 0; i < kNodesPerSide; ++i) {
      const bezier_double::BezierNode d = bezier_node(patch.exact, eye, grid_parameter(i, j, kNodesPerSide));
      bezier_float::BezierNode f{};
      f.x = glm::vec2(d.x);
      f.position = glm::vec3(d.position);
      f.normal = glm::vec3(d.normal);
      f.height = static_cast<float>(d.height);
      f.side = static_cast<float>(d.side);
      f.dual_x = glm::vec3(d.dual_x);
      f.dual_y = glm::vec3(d.dual_y);
      f.direction = glm::vec3(d.direction);
      f.inverse_focus = static_cast<float>(d.inverse_focus);
      nodes.push_back(f);
      seen[d.side > 0.0] = true;
      careful |= d.height < kEdgeOn * glm::length(eye - d.position);
    }
  careful |= seen[0] && seen[1];
  for (int k = 0; k < 2; ++k) {
    if (!seen[k]) continue;
    const float side = k == 1 ? 1.0f : -1.0f;
    sides.push_back({nodes, side, careful, patch.convex_side == static_cast<double>(side)});
  }
  return sides;
}

bezier_float::BezierStart best_start(const ReflectorNodes& nodes, const glm::vec3& eye, const glm::vec3& p) {
  bezier_float::BezierStart start = bezier_float::no_start(nodes.side);
  for (const bezier_float::BezierNode& node : nodes.nodes) start = consider_node(start, node, eye, p);
  start.certified |= nodes.unique;
  return start;
}

}  // namespace maquette
