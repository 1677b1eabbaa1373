// Rules of glTF for materials with closed forms, in every mode, with scenes made here.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "render/gl/context.h"
#include "render/math/shared_formulas.h"
#include "render/renderer.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

constexpr const char* kModes[] = {"uniform", "bandwidth", "splitsum", "sg", "reference"};

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
    renderer.set_environment(test::constant_sky(sky));
    FrameRequest r;
    r.mode = mode;
    r.width = r.height = 32;
    r.samples = samples;
    r.camera.eye = {0.0f, 0.0f, 3.0f};
    r.camera.target = {0.0f, 0.0f, 0.0f};
    r.camera.fov_y_rad = 0.5f;
    r.settings.set("shading.visibility", std::string("none"));
    r.settings.set("reference.transport", std::string("direct"));
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

  GlContext context_ = GlContext::create_headless();
};

TEST_F(MaterialRules, OcclusionDimsTheSkyAlone) {
  Material m = test::matte({0.6f, 0.4f, 0.2f});
  m.emissive = glm::vec3(0.25f);
  m.occlusion_texture.image = 0;
  m.occlusion_strength = 0.5f;
  Stage stage(m);
  stage.add_image(1, 1, {51, 0, 0, 255});  // 0.2: a factor of 0.6 at half strength
  const glm::vec3 color(0.6f, 0.4f, 0.2f);
  expect(stage, 2.0f, color * 2.0f * 0.6f + 0.25f, 0.01f);
  stage.add_light(3.0f);
  expect(stage, 2.0f, color * (2.0f * 0.6f + 3.0f / 3.14159265f) + 0.25f, 0.01f, true);
}

TEST_F(MaterialRules, UnlitShowsItsBaseColourOnly) {
  Material m = test::matte({0.5f, 0.25f, 0.125f});
  m.unlit = true;
  m.emissive = glm::vec3(3.0f);
  m.occlusion_texture.image = m.base_color_texture.image = m.normal_texture.image = 0;
  Stage stage(m);
  stage.add_image(1, 1, {255, 188, 255, 255});
  stage.colors().assign(4, {1.0f, 1.0f, 0.5f, 1.0f});
  const float green = std::pow((188.0f / 255.0f + 0.055f) / 1.055f, 2.4f);
  expect(stage, 7.0f, {0.5f, 0.25f * green, 0.0625f}, 0.02f);
}

TEST_F(MaterialRules, AlphaIsFactorTimesTextureTimesVertex) {
  const Material wall = test::matte(glm::vec3(0.5f));
  Material m = test::matte(glm::vec3(0.9f, 0.1f, 0.4f));
  m.base_color.a = 0.8f;
  m.base_color_texture.image = 0;
  for (const AlphaMode mode : {AlphaMode::mask, AlphaMode::blend})
    for (const float cutoff : {0.29f, 0.31f}) {  // of 0.8 * 0.5 * 0.75 = 0.3
      m.alpha_mode = mode;
      m.alpha_cutoff = cutoff;
      Stage stage(m, &wall);
      stage.add_image(1, 1, {255, 255, 255, 128});
      stage.colors().assign(4, glm::vec4(1.0f, 1.0f, 1.0f, 0.75f));
      const float alpha = 0.8f * 0.75f * 128.0f / 255.0f;
      const float share = mode == AlphaMode::blend ? alpha : alpha < cutoff ? 0.0f : 1.0f;
      expect(stage, 1.0f, share * glm::vec3(0.9f, 0.1f, 0.4f) + (1.0f - share) * glm::vec3(0.5f), 0.02f);
    }
}

/// Blending composites what an opaque surface of the material shows, whatever its lobes, and several layers of it.
TEST_F(MaterialRules, BlendedSurfacesAreShadedLikeOpaqueOnes) {
  Material m;
  m.base_color = {0.8f, 0.5f, 0.2f, 1.0f};
  m.metallic = 0.7f;
  m.roughness = 0.4f;
  m.clearcoat = 0.5f;
  m.clearcoat_roughness = 0.3f;
  m.emissive = glm::vec3(0.1f);
  const Material wall = test::matte(glm::vec3(0.5f));
  for (const std::string mode : {"uniform", "bandwidth", "splitsum", "sg"}) {
    Stage opaque(m, &wall);
    opaque.add_light(2.0f);
    const glm::vec3 shown = draw(opaque, mode, 1.0f, 1024);
    Stage only_wall(wall);
    only_wall.add_light(2.0f);
    const glm::vec3 behind = draw(only_wall, mode, 1.0f, 1024);
    Material blended = m;
    blended.alpha_mode = AlphaMode::blend;
    blended.base_color.a = 0.25f;
    Stage stage(blended, &wall);
    stage.add_light(2.0f);
    test::add(&stage.scene, test::make_grid({-1, -1, -0.5f}, {2, 0, 0}, {0, 2, 0}, 1, 0));
    const glm::vec3 found = draw(stage, mode, 1.0f, 1024);
    const glm::vec3 value = 0.25f * shown + 0.75f * (0.25f * shown + 0.75f * behind);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], value[c], 0.02f * value[c]) << mode << ", channel " << c;
  }
  EXPECT_TRUE(take_gl_errors().empty());
}

TEST_F(MaterialRules, ADisplayKeepsItsLuminanceWhenItIsSmall) {
  Material m = test::matte(glm::vec3(0.0f));
  m.emissive = glm::vec3(400.0f);
  m.emissive_texture.image = 0;
  m.emissive_texture.scale = glm::vec2(40.0f);  // many texels a pixel
  Stage stage(m);
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < 37 * 23; ++i)
    rgba.insert(rgba.end(), {static_cast<std::uint8_t>(i % 5 == 0 ? 255 : 0), 100, 128, 255});
  stage.add_image(37, 23, rgba);
  const auto linear = [](float v) { return v <= 0.04045f ? v / 12.92f : std::pow((v + 0.055f) / 1.055f, 2.4f); };
  const float lit = std::ceil(37.0f * 23.0f / 5.0f) / (37.0f * 23.0f);
  expect(stage, 0.0f, 400.0f * glm::vec3(lit, linear(100.0f / 255.0f), linear(128.0f / 255.0f)), 0.01f);
}

TEST_F(MaterialRules, AVolumeAbsorbsOverItsThickness) {
  const Material wall = test::matte(glm::vec3(0.5f));
  Material m = test::matte(glm::vec3(1.0f));
  m.glass = true;
  m.transmission = 1.0f;
  m.ior = 1.0f;  // reflects nothing
  m.thickness = 0.2f;
  m.attenuation_color = {0.9f, 0.5f, 0.1f};
  m.attenuation_distance = 0.4f;
  const Stage stage(m, &wall);
  expect(stage, 1.0f, 0.5f * glm::sqrt(m.attenuation_color), 0.02f);
}

/// A tilted slab, scaled by its node, with a texture of its thickness: the refracted way counts, and what both faces
/// reflect.
TEST_F(MaterialRules, ATiltedVolumeAbsorbsAlongTheRefractedWay) {
  const Material wall = test::matte(glm::vec3(0.5f));
  Material m = test::matte(glm::vec3(1.0f));
  m.glass = true;
  m.transmission = 1.0f;
  m.ior = 1.5f;
  m.thickness = 0.2f;
  m.thickness_texture.image = 0;
  m.attenuation_color = {0.9f, 0.5f, 0.1f};
  m.attenuation_distance = 0.4f;
  Stage stage(m, &wall);
  stage.add_image(1, 1, {0, 128, 0, 255});
  constexpr float kTilt = 0.9f, kScale = 2.0f;
  stage.scene.nodes[0].local =
      glm::scale(glm::rotate(glm::mat4(1.0f), kTilt, glm::vec3(0.0f, 1.0f, 0.0f)), glm::vec3(kScale));
  const float cosine = std::cos(kTilt), inside_cosine = std::sqrt(1.0f - (1.0f - cosine * cosine) / (1.5f * 1.5f));
  const float way = 0.2f * kScale * (128.0f / 255.0f) / inside_cosine;
  glm::vec3 value(0.0f);
  for (int c = 0; c < 3; ++c) {
    const glm::vec2 pane = shared::fresnel_pane(cosine, 1.5f, std::pow(m.attenuation_color[c], way / 0.4f));
    value[c] = pane.x * 1.0f + pane.y * 0.5f;
  }
  expect(stage, 1.0f, value, 0.02f);
}

/// A fifth layer looks like the fourth: with equal layers nothing is lost.
TEST_F(MaterialRules, MoreLayersThanAreShadedKeepTheirCoverage) {
  const Material wall = test::matte(glm::vec3(0.5f));
  Material m = test::matte(glm::vec3(0.8f, 0.2f, 0.4f));
  m.alpha_mode = AlphaMode::blend;
  m.base_color.a = 0.3f;
  Stage stage(m, &wall);
  for (int k = 1; k < 6; ++k)
    test::add(&stage.scene, test::make_grid({-1, -1, -0.1f * static_cast<float>(k)}, {2, 0, 0}, {0, 2, 0}, 1, 0));
  const float through = std::pow(0.7f, 6.0f);
  expect(stage, 1.0f, (1.0f - through) * glm::vec3(0.8f, 0.2f, 0.4f) + through * glm::vec3(0.5f), 0.02f);
}

TEST_F(MaterialRules, GlassIsCutOutToo) {
  const Material wall = test::matte(glm::vec3(0.5f));
  Material m = test::matte(glm::vec3(0.2f));
  m.glass = true;
  m.transmission = 0.5f;
  m.alpha_mode = AlphaMode::mask;
  m.base_color.a = 0.4f;
  const Stage stage(m, &wall);
  expect(stage, 1.0f, glm::vec3(0.5f), 0.01f);
}

/// Dark linear colours of vertices keep their digits.
TEST_F(MaterialRules, VertexColoursAreNotRounded) {
  for (const float v : {0.001f, 0.003f, 0.0055f, 0.4f}) {
    Stage stage(test::matte(glm::vec3(1.0f)));
    stage.colors().assign(4, glm::vec4(glm::vec3(v), 1.0f));
    Stage factor(test::matte(glm::vec3(v)));
    for (const std::string mode : kModes)
      EXPECT_NEAR(draw(stage, mode, 1.0f).x, draw(factor, mode, 1.0f).x, 0.01f * v) << mode << ", " << v;
  }
}

}  // namespace
}  // namespace maquette
