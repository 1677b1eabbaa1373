#include "render/lights/light_numbers.h"

namespace maquette {

std::vector<float> light_numbers(const Scene& scene) {
  std::vector<float> numbers;
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  for (std::size_t n = 0; n < scene.nodes.size(); ++n) {
    const Node& node = scene.nodes[n];
    if (!node.visible || node.light < 0 || node.light >= static_cast<int>(scene.lights.size())) continue;
    const PunctualLight& l = scene.lights[static_cast<std::size_t>(node.light)];
    numbers.insert(numbers.end(), {static_cast<float>(l.kind), l.color.x, l.color.y, l.color.z, l.intensity, l.range_m,
                                   l.inner_cone_rad, l.outer_cone_rad});
    for (int c = 0; c < 4; ++c)
      for (int r = 0; r < 3; ++r) numbers.push_back(world[n][c][r]);
  }
  return numbers;
}

}  // namespace maquette
