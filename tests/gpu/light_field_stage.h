#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "render/renderer.h"
#include "tests/gpu/drawn.h"
#include "tests/support/test_scenes.h"

/// Small pictures of mode slf.
namespace maquette {

inline FrameRequest request_for(int texels) {
  FrameRequest r;
  r.mode = "slf";
  r.width = 64;
  r.height = 48;
  r.settings.set("slf.texels", texels);
  r.settings.set("slf.paths", 2);
  r.settings.set("shading.visibility", std::string("none"));
  return r;
}

/// A box with a lamp, its back wall of two colours: interreflection, shadows and the seams between walls.
inline std::shared_ptr<Scene> lit_box() {
  auto scene = std::make_shared<Scene>(test::box_scene(5, 4, test::matte({0.6f, 0.5f, 0.4f})));
  Material glow = test::matte(glm::vec3(0.0f));
  glow.emissive = glm::vec3(12.0f, 10.0f, 8.0f);
  Material gloss;
  gloss.name = "gloss";
  gloss.roughness = std::sqrt(0.5f);
  gloss.base_color = glm::vec4(0.7f, 0.7f, 0.7f, 1.0f);
  scene->materials.push_back(glow);
  scene->materials.push_back(gloss);
  test::add(scene.get(), test::make_grid({-0.4f, 0.95f, -0.4f}, {0.8f, 0, 0}, {0, 0, 0.8f}, 1, 1), "lamp");
  test::add(scene.get(), test::make_grid({-0.5f, -0.6f, -0.6f}, {0.9f, 0, 0.2f}, {0, 0.7f, -0.2f}, 4, 2), "panel");
  return scene;
}

}  // namespace maquette
