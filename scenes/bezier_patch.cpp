#include <algorithm>
#include <cmath>

#include "scenes/subdivision.h"

namespace maquette {
namespace {

struct Cubic {
  std::array<double, 4> value;
  std::array<double, 4> derivative;
};

/// Bernstein polynomials of degree 3 and their derivatives.
Cubic bernstein(double t) {
  const double s = 1.0 - t;
  return {{s * s * s, 3.0 * s * s * t, 3.0 * s * t * t, t * t * t},
          {-3.0 * s * s, 3.0 * s * s - 6.0 * s * t, 6.0 * s * t - 3.0 * t * t, 3.0 * t * t}};
}

struct SurfacePoint {
  glm::dvec3 position{0.0}, along_u{0.0}, along_v{0.0};
};

SurfacePoint evaluate(const BezierPatch& patch, double u, double v) {
  const Cubic cubic_u = bernstein(u), cubic_v = bernstein(v);
  SurfacePoint out;
  for (std::size_t row = 0; row < 4; ++row) {
    for (std::size_t column = 0; column < 4; ++column) {
      const glm::dvec3 point(patch.points[4 * row + column]);
      out.position += cubic_v.value[row] * cubic_u.value[column] * point;
      out.along_u += cubic_v.value[row] * cubic_u.derivative[column] * point;
      out.along_v += cubic_v.derivative[row] * cubic_u.value[column] * point;
    }
  }
  return out;
}

/// Unit normal along dS/du x dS/dv. Where an edge of the patch is collapsed to a point the product vanishes, and the
/// limit is taken from a point just inside.
glm::dvec3 normal_at(const BezierPatch& patch, double u, double v) {
  constexpr double kDegenerate = 1e-9;  // relative to the product of the lengths: smaller results are rounding noise
  constexpr double kInside = 1e-4;
  for (const double step : {0.0, kInside, 100.0 * kInside}) {
    const SurfacePoint p = evaluate(patch, u + step * (0.5 - u), v + step * (0.5 - v));
    const glm::dvec3 normal = glm::cross(p.along_u, p.along_v);
    const double size = std::max(glm::dot(p.along_u, p.along_u), glm::dot(p.along_v, p.along_v));
    if (glm::length(normal) > kDegenerate * size) return glm::normalize(normal);
  }
  return {0.0, 1.0, 0.0};
}

double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

}  // namespace

PatchSides patch_sides(const BezierPatch& patch) {
  constexpr double kAngle_rad = 0.006;
  constexpr int kLines = 4, kSteps = 16, kLeast = 16, kMost = 128;
  // Largest change of direction along the lines of one parameter, of the normals or of the lines themselves.
  const auto side = [&](bool along_u) {
    double most_rad = 0.0;
    for (int line = 0; line <= kLines; ++line) {
      double normals_rad = 0.0, tangents_rad = 0.0;
      glm::dvec3 last_normal{0.0}, last_tangent{0.0};
      for (int step = 0; step <= kSteps; ++step) {
        const double along = static_cast<double>(step) / kSteps, across = static_cast<double>(line) / kLines;
        const double u = along_u ? along : across, v = along_u ? across : along;
        const SurfacePoint point = evaluate(patch, u, v);
        const glm::dvec3 normal = normal_at(patch, u, v), tangent = along_u ? point.along_u : point.along_v;
        if (step > 0) normals_rad += angle_between(last_normal, normal);
        if (step > 0) tangents_rad += angle_between(last_tangent, tangent);
        last_normal = normal;
        last_tangent = tangent;
      }
      most_rad = std::max({most_rad, normals_rad, tangents_rad});
    }
    return std::clamp(static_cast<int>(std::ceil(most_rad / kAngle_rad)), kLeast, kMost);
  };
  return {side(true), side(false)};
}

Primitive tessellate_patch(const BezierPatch& patch, const PatchSides& sides) {
  const int columns = std::max(sides.u, 1), rows = std::max(sides.v, 1);
  Primitive out;
  out.material = patch.material;
  for (int row = 0; row <= rows; ++row) {
    for (int column = 0; column <= columns; ++column) {
      const double u = static_cast<double>(column) / columns, v = static_cast<double>(row) / rows;
      const SurfacePoint point = evaluate(patch, u, v);
      out.positions.emplace_back(point.position);
      out.normals.emplace_back(normal_at(patch, u, v));
      out.uvs[0].emplace_back(u, v);
    }
  }
  const auto width = static_cast<std::uint32_t>(columns), height = static_cast<std::uint32_t>(rows);
  for (std::uint32_t row = 0; row < height; ++row) {
    for (std::uint32_t column = 0; column < width; ++column) {
      const std::uint32_t a = row * (width + 1) + column, b = a + 1, c = b + width, d = c + 1;
      out.indices.insert(out.indices.end(), {a, b, d, a, d, c});
    }
  }
  return out;
}

}  // namespace maquette
