#pragma once

#include <glm/glm.hpp>
#include <memory>
#include <string>
#include <utility>

#include "scenes/environment.h"
#include "scenes/scene.h"

/// Small scenes for many tests.
namespace maquette::test {

/// 8 x 8 texels of two colours in turn.
inline TextureImage checkerboard() {
  TextureImage checks;
  checks.width = checks.height = 8;
  for (int i = 0; i < 64; ++i) {
    const std::uint8_t v = (i + i / 8) % 2 ? 255 : 20;
    checks.rgba.insert(checks.rgba.end(), {v, 90, static_cast<std::uint8_t>(255 - v), 255});
  }
  return checks;
}

/// `side` x `side` quads from `corner`; normal along cross(u, v).
inline Primitive make_grid(const glm::vec3& corner, const glm::vec3& u, const glm::vec3& v, int side, int material) {
  Primitive p;
  p.material = material;
  for (int j = 0; j <= side; ++j)
    for (int i = 0; i <= side; ++i) {
      p.positions.push_back(corner + u * (static_cast<float>(i) / static_cast<float>(side)) +
                            v * (static_cast<float>(j) / static_cast<float>(side)));
      p.normals.push_back(glm::normalize(glm::cross(u, v)));
    }
  const auto at = [side](int i, int j) { return static_cast<std::uint32_t>(j * (side + 1) + i); };
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i)
      p.indices.insert(p.indices.end(),
                       {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1)});
  return p;
}

/// Adds a root node with a mesh of its own.
inline Node* add(Scene* scene, Primitive primitive, const std::string& name = {}) {
  Node node;
  node.name = name;
  node.mesh = static_cast<int>(scene->meshes.size());
  scene->roots.push_back(static_cast<int>(scene->nodes.size()));
  scene->nodes.push_back(node);
  scene->meshes.emplace_back();
  scene->meshes.back().primitives.push_back(std::move(primitive));
  return &scene->nodes.back();
}

/// The first `walls` of six walls of the box [-1, 1]^3, of `side` x `side` quads, facing inwards: floor, back, left,
/// right, front, roof. Material 0.
inline Scene box_scene(int walls, int side, const Material& material) {
  Scene scene;
  scene.materials.push_back(material);
  const glm::vec3 frames[][3] = {{{-1, -1, 1}, {2, 0, 0}, {0, 0, -2}}, {{-1, -1, -1}, {2, 0, 0}, {0, 2, 0}},
                                 {{-1, -1, 1}, {0, 0, -2}, {0, 2, 0}}, {{1, -1, -1}, {0, 0, 2}, {0, 2, 0}},
                                 {{1, -1, 1}, {-2, 0, 0}, {0, 2, 0}},  {{-1, 1, -1}, {2, 0, 0}, {0, 0, 2}}};
  for (int i = 0; i < walls; ++i) add(&scene, make_grid(frames[i][0], frames[i][1], frames[i][2], side, 0));
  return scene;
}

/// The unit sphere with one material.
inline Scene sphere_of(const Material& material) {
  Scene scene = load_scene("builtin:sphere");
  for (Material& m : scene.materials) {
    const std::string name = m.name;
    m = material;
    m.name = name;
  }
  return scene;
}

/// A Lambertian material without specular reflection.
inline Material matte(const glm::vec3& albedo) {
  Material m;
  m.base_color = glm::vec4(albedo, 1.0f);
  m.metallic = 0.0f;
  m.specular = 0.0f;
  return m;
}

/// Smooth glass that transmits all that it does not reflect.
inline Material clear_pane() {
  Material m;
  m.glass = true;
  m.transmission = 1.0f;
  m.metallic = 0.0f;
  m.roughness = 0.0f;
  return m;
}

inline Material white_lambert() { return matte(glm::vec3(1.0f)); }

inline std::shared_ptr<Environment> constant_sky(const glm::vec3& radiance) {
  auto sky = std::make_shared<Environment>();
  sky->name = "constant";
  sky->width = 32;
  sky->height = 16;
  sky->rgb.assign(32 * 16, radiance);
  return sky;
}
inline std::shared_ptr<Environment> constant_sky(float radiance) { return constant_sky(glm::vec3(radiance)); }
/// An uneven sky of colour `color` with a lamp of four texels, and one quarter dark.
inline std::shared_ptr<Environment> sky_with_lamp(const glm::vec3& color, const glm::vec3& lamp) {
  auto environment = std::make_shared<Environment>();
  environment->width = 64;
  environment->height = 32;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 64; ++x) {
      const float sky = x < 16 ? 0.0f : 1.0f + 0.5f * std::sin(0.7f * static_cast<float>(x + 3 * y));
      const bool is_lamp = y >= 8 && y < 10 && x >= 40 && x < 42;
      environment->rgb.push_back(is_lamp ? lamp : sky * color);
    }
  return environment;
}

}  // namespace maquette::test
