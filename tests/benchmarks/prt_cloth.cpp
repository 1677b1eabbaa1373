#include "tests/benchmarks/prt_cloth.h"

#include <algorithm>
#include <cmath>

#include "tests/support/test_scenes.h"

namespace maquette::bench {
namespace {

constexpr int kSide = 58;  ///< 58 x 58 vertices

/// A cloth of 0.8 m that lies over a ball and falls in folds around it.
Primitive draped_cloth() {
  Primitive cloth = test::make_grid({-0.4f, 0.0f, 0.4f}, {0.8f, 0.0f, 0.0f}, {0.0f, 0.0f, -0.8f}, kSide - 1, 0);
  for (glm::vec3& p : cloth.positions) {
    const float radius = std::sqrt(p.x * p.x + p.z * p.z), angle = std::atan2(p.z, p.x);
    cloth.uvs[0].emplace_back(p.x / 0.8f + 0.5f, p.z / 0.8f + 0.5f);
    const float fall = std::max(radius - 0.12f, 0.0f);
    p.y = 0.25f - 0.9f * radius * radius / (radius + 0.25f) + 0.16f * fall * std::sin(9.0f * angle) +
          0.03f * fall * std::sin(31.0f * radius + 3.0f * angle);
  }
  std::fill(cloth.normals.begin(), cloth.normals.end(), glm::vec3(0.0f));
  for (std::size_t i = 0; i + 2 < cloth.indices.size(); i += 3) {
    const glm::vec3 a = cloth.positions[cloth.indices[i]];
    const glm::vec3 n =
        glm::cross(cloth.positions[cloth.indices[i + 1]] - a, cloth.positions[cloth.indices[i + 2]] - a);
    for (std::size_t k = 0; k < 3; ++k) cloth.normals[cloth.indices[i + k]] += n;
  }
  for (glm::vec3& n : cloth.normals) n = glm::normalize(n);
  return cloth;
}

}  // namespace

std::shared_ptr<const Scene> cloth_covered(const std::string& cover) {
  auto scene = std::make_shared<Scene>();
  scene->name = "cloth";
  scene->materials.push_back(test::matte(glm::vec3(0.5f)));
  scene->materials[0].name = "cover";
  scene->materials[0].measured = cover;
  test::add(scene.get(), draped_cloth(), "cloth");
  return scene;
}

}  // namespace maquette::bench
