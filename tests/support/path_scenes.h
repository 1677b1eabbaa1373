#pragma once

#include <functional>
#include <memory>

#include "render/reference/reference.h"
#include "tests/support/test_scenes.h"

namespace maquette::test {

/// Latitude-longitude map of a function of the unit direction, at texel centres.
inline std::shared_ptr<const Environment> sky_of(int width, int height,
                                                 const std::function<glm::dvec3(const glm::dvec3&)>& f) {
  auto sky = std::make_shared<Environment>();
  sky->width = width;
  sky->height = height;
  constexpr double kPi = 3.14159265358979323846;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x) {
      const double lon = kPi - 2.0 * kPi * (x + 0.5) / width, lat = kPi / 2 - kPi * (y + 0.5) / height;
      sky->rgb.emplace_back(f({std::sin(lon) * std::cos(lat), std::sin(lat), std::cos(lon) * std::cos(lat)}));
    }
  }
  return sky;
}

/// One primitive with one material, at the root.
inline Scene scene_of(Primitive primitive, const Material& material) {
  Scene scene;
  primitive.material = 0;
  scene.materials.push_back(material);
  Mesh mesh;
  mesh.primitives.push_back(std::move(primitive));
  scene.meshes.push_back(std::move(mesh));
  Node node;
  node.mesh = 0;
  scene.nodes.push_back(node);
  scene.roots.push_back(0);
  return scene;
}

/// Parallelogram, front towards cross(a, b).
inline Primitive quad(const glm::vec3& origin, const glm::vec3& a, const glm::vec3& b) {
  Primitive p;
  const glm::vec3 normal(glm::normalize(glm::cross(glm::dvec3(a), glm::dvec3(b))));
  p.positions = {origin, origin + a, origin + a + b, origin + b};
  p.normals.assign(4, normal);
  p.indices = {0, 1, 2, 0, 2, 3};
  return p;
}

inline std::shared_ptr<const PathScene> trace(const Scene& scene, std::shared_ptr<const Environment> sky) {
  return build_path_scene({.scene = scene, .environment = std::move(sky)});
}

/// Unit sphere of `rings` by 2 `rings` quads with exact normals.
inline Primitive fine_sphere(int rings) {
  Primitive p;
  constexpr double kPi = 3.14159265358979323846;
  for (int j = 0; j <= rings; ++j)
    for (int i = 0; i <= 2 * rings; ++i) {
      const double theta = kPi * j / rings, phi = kPi * i / rings;
      p.positions.emplace_back(std::sin(theta) * std::sin(phi), std::cos(theta), std::sin(theta) * std::cos(phi));
    }
  p.normals = p.positions;
  const auto row = static_cast<std::uint32_t>(2 * rings + 1);
  for (std::uint32_t j = 0; j < static_cast<std::uint32_t>(rings); ++j)
    for (std::uint32_t i = 0; i + 1 < row; ++i) {
      const std::uint32_t a = j * row + i, b = a + row;
      p.indices.insert(p.indices.end(), {a, b, b + 1, a, b + 1, a + 1});
    }
  return p;
}

struct MeanRadiance {
  glm::dvec3 mean{0.0};
  double deviation = 0.0;  ///< standard deviation of the mean of Y, from 16 runs of the sequence
};

/// Mean of `count` paths along one ray.
MeanRadiance mean_radiance(const PathScene& scene, const PathOptions& options, const glm::vec3& origin,
                           const glm::vec3& direction, std::uint32_t count, std::uint32_t seed = 1);

}  // namespace maquette::test
