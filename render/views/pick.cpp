#include "render/views/pick.h"

#include <limits>

#include "render/math/shared_formulas.h"

namespace maquette {

Pick pick_triangle(const SceneState& scene, std::uint32_t triangle, const glm::vec3& position, const glm::vec3& ray) {
  Pick pick;
  pick.hit = true;
  pick.position = position;
  const FlatGeometry& g = scene.geometry();
  const std::size_t first = 3 * static_cast<std::size_t>(triangle);
  const glm::vec3 a = g.positions[g.indices[first]], b = g.positions[g.indices[first + 1]],
                  d = g.positions[g.indices[first + 2]];
  pick.normal = glm::normalize(glm::cross(b - a, d - a));
  pick.triangle = triangle;
  pick.back = glm::dot(pick.normal, ray) > 0.0f;
  if (pick.back) pick.normal = -pick.normal;
  for (std::size_t i = 0; i < g.items.size(); ++i) {
    const DrawItem& item = g.items[i];
    if (first < item.first_index || first >= item.first_index + item.index_count) continue;
    pick.node = item.node;
    pick.primitive = item.primitive;
    pick.material = scene.buffers().material(i);
  }
  return pick;
}

Pick pick_by_ray(const SceneState& scene, const FrameRequest& request, int x, int y) {
  const FlatGeometry& g = scene.geometry();
  const CameraFrame camera = make_camera_frame(request.camera, request.width, request.height, scene.bounds());
  const glm::vec2 ndc((2.0f * static_cast<float>(x) + 1.0f) / static_cast<float>(request.width) - 1.0f,
                      1.0f - (2.0f * static_cast<float>(y) + 1.0f) / static_cast<float>(request.height));
  const EyeRay ray = camera.ray_through(ndc);
  float nearest = std::numeric_limits<float>::max();
  std::uint32_t triangle = 0;
  for (std::size_t i = 0; i < g.items.size(); ++i) {
    const DrawItem& item = g.items[i];
    if (!scene.buffers().visible(i) || scene.is_transparent(i)) continue;
    const bool culled = !scene.shows_both_sides(i);
    for (std::uint32_t k = item.first_index; k + 2 < item.first_index + item.index_count; k += 3) {
      const glm::vec3 a = g.positions[g.indices[k]], e1 = g.positions[g.indices[k + 1]] - a,
                      e2 = g.positions[g.indices[k + 2]] - a;
      const shared::TriangleHit hit = shared::intersect_plane_of_triangle(ray.origin, ray.direction, a, e1, e2);
      const bool inside =
          hit.barycentric.x >= 0.0f && hit.barycentric.y >= 0.0f && hit.barycentric.x + hit.barycentric.y <= 1.0f;
      if (!inside || hit.depth < camera.near_m || hit.depth >= nearest) continue;
      if (culled && glm::dot(glm::cross(e1, e2), ray.direction) > 0.0f) continue;
      nearest = hit.depth;
      triangle = k / 3;
    }
  }
  if (nearest == std::numeric_limits<float>::max()) return {};
  return pick_triangle(scene, triangle, ray.origin + ray.direction * nearest, ray.direction);
}

}  // namespace maquette
