#pragma once

#include <gtest/gtest.h>

#include <memory>
#include <string>
#include <vector>

#include "render/gl/context.h"
#include "render/renderer.h"
#include "tests/support/test_scenes.h"

/// A stage for rules of materials with closed forms.
namespace maquette {

inline constexpr const char* kModes[] = {"uniform", "bandwidth", "splitsum", "sg", "reference"};

/// A square before the eye; behind it, where `wall` says so, a large one.
struct Stage {
  Scene scene;
  explicit Stage(const Material& material, const Material* wall = nullptr) {
    scene.materials.push_back(material);
    Primitive front = test::make_grid({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 1, 0);
    front.uvs[0] = {{0, 0}, {1, 0}, {0, 1}, {1, 1}};
    test::add(&scene, front);
    if (!wall) return;
    scene.materials.push_back(*wall);
    test::add(&scene, test::make_grid({-9, -9, -1}, {18, 0, 0}, {0, 18, 0}, 1, 1));
  }
  void add_image(int width, int height, const std::vector<std::uint8_t>& rgba) {
    TextureImage image;
    image.width = width;
    image.height = height;
    image.rgba = rgba;
    scene.images.push_back(image);
  }
  /// Straight at the square, irradiance `lux`.
  void add_light(float lux) {
    PunctualLight light;
    light.kind = PunctualLight::Kind::directional;
    light.intensity = lux;
    scene.lights.push_back(light);
    Node node;
    node.light = 0;
    scene.roots.push_back(static_cast<int>(scene.nodes.size()));
    scene.nodes.push_back(node);
  }
  std::vector<glm::vec4>& colors() { return scene.meshes[0].primitives[0].colors; }
};

class MaterialRules : public ::testing::Test {
 protected:
  /// Mean of the middle.
  glm::vec3 draw(const Stage& stage, const std::string& mode, float sky, int samples = 256) {
    Renderer renderer;
    renderer.set_scene(std::make_shared<Scene>(stage.scene));
    renderer.set_environment(sky_ ? sky_ : test::constant_sky(sky));
    FrameRequest r;
    r.mode = mode;
    r.width = r.height = 32;
    r.samples = samples;
    r.camera.eye = {0.0f, 0.0f, 3.0f};
    r.camera.target = {0.0f, 0.0f, 0.0f};
    r.camera.fov_y_rad = 0.5f;
    r.settings.set("shading.visibility", std::string("none"));
    r.settings.set("reference.transport", transport_);
    renderer.render(r);
    const Image image = renderer.read_radiance();
    glm::vec3 sum(0.0f);
    for (int y = 12; y < 20; ++y)
      for (int x = 12; x < 20; ++x)
        for (int c = 0; c < 3; ++c) sum[c] += image.at(x, y, c) / 64.0f;
    return sum;
  }
  static bool has_lights(const std::string& mode) { return mode != "splitsum" && mode != "sg"; }
  void expect(const Stage& stage, float sky, const glm::vec3& value, float relative, bool needs_lights = false) {
    for (const std::string mode : kModes) {
      if (needs_lights && !has_lights(mode)) continue;
      const glm::vec3 found = draw(stage, mode, sky);
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(found[c], value[c], relative * value[c] + 1e-4f) << mode << ", channel " << c;
    }
    EXPECT_TRUE(take_gl_errors().empty());
  }

  std::string transport_ = "direct";  ///< of mode reference
  std::shared_ptr<Environment> sky_;  ///< instead of a constant one
  GlContext context_ = GlContext::create_headless();
};

}  // namespace maquette
