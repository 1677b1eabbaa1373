#include "render/glass/depth_order.h"

#include <algorithm>

namespace maquette {

bool faces_both_ways(std::span<const glm::vec3> positions, std::span<const std::uint32_t> indices,
                     const glm::vec3& eye) {
  bool front = false, back = false;
  for (std::size_t i = 0; i + 2 < indices.size() && !(front && back); i += 3) {
    const glm::vec3 &a = positions[indices[i]], &b = positions[indices[i + 1]], &c = positions[indices[i + 2]];
    const float side = glm::dot(glm::cross(b - a, c - a), eye - a);
    front |= side > 0.0f;
    back |= side < 0.0f;
  }
  return front && back;
}

std::vector<std::uint32_t> back_to_front(std::span<const glm::vec3> positions, std::span<const std::uint32_t> indices,
                                         const glm::vec3& eye) {
  struct Triangle {
    float distance = 0.0f;  // squared, of three times the centroid
    std::size_t first = 0;
  };
  std::vector<Triangle> triangles(indices.size() / 3);
  for (std::size_t t = 0; t < triangles.size(); ++t) {
    const glm::vec3 d =
        positions[indices[3 * t]] + positions[indices[3 * t + 1]] + positions[indices[3 * t + 2]] - 3.0f * eye;
    triangles[t] = {glm::dot(d, d), 3 * t};
  }
  std::stable_sort(triangles.begin(), triangles.end(),
                   [](const Triangle& a, const Triangle& b) { return a.distance > b.distance; });
  std::vector<std::uint32_t> sorted;
  sorted.reserve(3 * triangles.size());
  for (const Triangle& t : triangles)
    sorted.insert(sorted.end(), {indices[t.first], indices[t.first + 1], indices[t.first + 2]});
  return sorted;
}

}  // namespace maquette
