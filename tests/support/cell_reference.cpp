#include "tests/support/cell_reference.h"

#include <cmath>
#include <limits>

#include "render/octree/octree_shared.h"

namespace maquette::test {

namespace {

constexpr double kLift = 1e-7;

/// Distance along the ray to a polygon, or infinity.
double meet(const ClipPolygon& polygon, const glm::dvec3& o, const glm::dvec3& d) {
  const glm::dvec3 n = polygon_area_vector(polygon);
  const double along = glm::dot(n, d);
  if (std::abs(along) < 1e-14) return std::numeric_limits<double>::infinity();
  const double t = glm::dot(n, polygon.corners[0] - o) / along;
  const glm::dvec3 p = o + t * d;
  for (int i = 0; i < polygon.count; ++i) {
    const glm::dvec3 &a = polygon.corners[i], &b = polygon.corners[(i + 1) % polygon.count];
    if (glm::dot(n, glm::cross(b - a, p - a)) < 0.0) return std::numeric_limits<double>::infinity();
  }
  return t > 0.0 ? t : std::numeric_limits<double>::infinity();
}

bool is_free(const CellContent& content, const glm::dvec3& o, const glm::dvec3& d) {
  for (const ClipPolygon& p : content.polygons)
    if (std::isfinite(meet(p, o, d))) return false;
  return true;
}

/// A basis whose third vector is `n`, by the first axis that is not along it.
glm::dmat3 any_basis(const glm::dvec3& n) {
  const glm::dvec3 t = glm::normalize(glm::cross(std::abs(n.x) < 0.6 ? glm::dvec3(1, 0, 0) : glm::dvec3(0, 0, 1), n));
  return {t, glm::cross(n, t), n};
}

}  // namespace

ClipPolygon rectangle(const glm::dvec3& corner, const glm::dvec3& u, const glm::dvec3& v) {
  ClipPolygon p;
  p.count = 4;
  p.corners[0] = corner, p.corners[1] = corner + u, p.corners[2] = corner + u + v, p.corners[3] = corner + v;
  return p;
}

CellView compute_cell_view(const CellContent& content, const glm::dvec3& view, const std::vector<glm::dvec3>& lights,
                           int side) {
  CellView result;
  result.lit.assign(lights.size(), glm::dvec3(0.0));
  const glm::dmat3 screen = any_basis(view);
  const double radius = 0.5 * std::sqrt(3.0), pixel = 2.0 * radius / side;
  for (int y = 0; y < side; ++y) {
    for (int x = 0; x < side; ++x) {
      const glm::dvec3 o = glm::dvec3(0.5) + view * 2.0 + screen[0] * ((x + 0.5) * pixel - radius) +
                           screen[1] * ((y + 0.5) * pixel - radius);
      double nearest = std::numeric_limits<double>::infinity();
      std::size_t hit = 0;
      for (std::size_t k = 0; k < content.polygons.size(); ++k) {
        const double t = meet(content.polygons[k], o, -view);
        if (t < nearest) nearest = t, hit = k;
      }
      if (!std::isfinite(nearest)) continue;
      result.seen += pixel * pixel;
      glm::dvec3 n = glm::normalize(polygon_area_vector(content.polygons[hit]));
      if (glm::dot(n, view) < 0.0) n = -n;
      const glm::dmat3 local = glm::transpose(any_basis(n));
      const glm::dvec3 p = o - nearest * view + kLift * n;
      for (std::size_t i = 0; i < lights.size(); ++i) {
        const double cosine = glm::dot(n, lights[i]);
        if (cosine <= 0.0 || !is_free(content, p, lights[i])) continue;
        const glm::dvec3 f(content.reflectance[hit](glm::vec3(local * lights[i]), glm::vec3(local * view)));
        result.lit[i] += pixel * pixel * cosine * f;
      }
    }
  }
  return result;
}

Eigen::VectorXf bake_content(const CellContent& content, const glm::vec3& normal, int samples) {
  std::vector<const ClipPolygon*> polygons;
  for (const ClipPolygon& p : content.polygons) polygons.push_back(&p);
  const auto points = sample_polygons(polygons, 1.0, samples, 1);
  const CellVisibility visible = [&](const CellSample& s, const glm::vec3& d) {
    const glm::dvec3 direction(d);
    const double up = glm::dot(s.normal, direction) < 0.0 ? -kLift : kLift;
    return is_free(content, s.position + up * s.normal, direction);
  };
  return compute_cell_brdf(points, content.reflectance, cell_frame(normal), visible);
}

}  // namespace maquette::test
