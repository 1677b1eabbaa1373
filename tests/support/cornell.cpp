#include "tests/support/cornell.h"

#include <algorithm>
#include <cmath>

#include "scenes/scene.h"

namespace maquette::test {
namespace {

/// The scene's camera; see scenes/builtin.cpp.
constexpr double kEyeY = 2.73, kEyeZ = 10.8, kFovDegrees = 39.3;

/// Least distance from walls that a point does not lie on. Nearer points see so little of the wall that its elements
/// are too coarse.
constexpr double kCorner_m = 0.15;

bool is_in_corner(const SurfaceHit& hit) {
  const glm::dvec3 n = glm::abs(hit.normal), p = hit.position;
  return (n.x < 0.99 && 2.78 - std::abs(p.x) < kCorner_m) || (n.y < 0.99 && std::min(p.y, 5.488 - p.y) < kCorner_m) ||
         (n.z < 0.99 && p.z + 2.796 < kCorner_m);
}

/// A flat lattice of (n + 1)^2 vertices becomes two triangles: the solver splits them as finely as it needs.
std::vector<std::uint32_t> merged_indices(const Primitive& primitive) {
  const auto side = static_cast<std::uint32_t>(std::lround(std::sqrt(static_cast<double>(primitive.positions.size()))));
  const bool lattice =
      side * side == primitive.positions.size() && primitive.indices.size() == 6 * (side - 1) * (side - 1);
  const bool flat = std::all_of(primitive.normals.begin(), primitive.normals.end(),
                                [&](const glm::vec3& n) { return n == primitive.normals.front(); });
  if (!lattice || !flat) return primitive.indices;
  const std::uint32_t a = 0, b = side - 1, c = side * (side - 1), d = side * side - 1;
  const glm::vec3 normal =
      glm::cross(primitive.positions[b] - primitive.positions[a], primitive.positions[c] - primitive.positions[a]);
  if (glm::dot(normal, primitive.normals.front()) > 0.0f) return {a, b, d, a, d, c};
  return {a, d, b, a, c, d};
}

}  // namespace

std::vector<DiffuseTriangle> cornell_triangles() {
  const Scene scene = build_builtin_scene("cornell");
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  std::vector<DiffuseTriangle> triangles;
  for (std::size_t n = 0; n < scene.nodes.size(); ++n) {
    if (scene.nodes[n].mesh < 0) continue;
    for (const Primitive& primitive : scene.meshes[static_cast<std::size_t>(scene.nodes[n].mesh)].primitives) {
      const Material& material = scene.materials[static_cast<std::size_t>(primitive.material)];
      const std::vector<std::uint32_t> indices = merged_indices(primitive);
      for (std::size_t i = 0; i + 2 < indices.size(); i += 3) {
        DiffuseTriangle triangle;
        for (std::size_t k = 0; k < 3; ++k) {
          const glm::vec3& p = primitive.positions[indices[i + k]];
          triangle.corners[k] = glm::dvec3(world[n] * glm::vec4(p, 1.0f));
        }
        triangle.albedo = glm::dvec3(glm::vec3(material.base_color));
        triangle.emission = glm::dvec3(material.emissive);
        triangles.push_back(triangle);
      }
    }
  }
  return triangles;
}

std::vector<CornellPixel> CornellView::pixels(const Radiosity& radiosity) const {
  std::vector<CornellPixel> list;
  const double scale = std::tan(0.5 * kFovDegrees * 3.14159265358979323846 / 180.0);
  for (int y = 0; y < side_; ++y) {
    for (int x = 0; x < side_; ++x) {
      const glm::dvec3 direction(scale * (2.0 * (x + 0.5) / side_ - 1.0), -scale * (2.0 * (y + 0.5) / side_ - 1.0),
                                 -1.0);
      const auto hit = radiosity.first_hit({0.0, kEyeY, kEyeZ}, direction);
      if (!hit || !hit->front || hit->emission != glm::dvec3(0.0) || is_in_corner(*hit)) continue;
      // Walls and tops are parallel to an axis, and sides of the boxes are upright; bevels are neither.
      const glm::dvec3 n = glm::abs(hit->normal);
      if (n.y > 1e-4 && n.y < 1.0 - 1e-6) continue;
      if (n.y < 0.5 && hit->position.y > 0.004 && std::max(n.x, n.z) < 0.9999) {
        // The boxes are rotated by 17 and 17.5 degrees; an upright bevel by 45 degrees more.
        const double angle = std::atan2(std::min(n.x, n.z), std::max(n.x, n.z));
        if (angle > 0.4) continue;
      }
      list.push_back({x, y, *hit});
    }
  }
  return list;
}

}  // namespace maquette::test
