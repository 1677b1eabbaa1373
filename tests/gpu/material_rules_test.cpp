// Rules of glTF for materials with closed forms, in every mode, with scenes made here.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "render/math/shared_formulas.h"
#include "tests/gpu/material_stage.h"

namespace maquette {
namespace {

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
  m.specular = 1.0f;
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

/// Small channels beside large ones keep their digits, of factors and of textures.
TEST_F(MaterialRules, EmissionKeepsEveryChannel) {
  Material m = test::matte(glm::vec3(0.0f));
  m.emissive = {1000.0f, 1.0f, 0.1f};
  expect(Stage(m), 0.0f, m.emissive, 0.003f);
  m.emissive = glm::vec3(1000.0f);
  m.emissive_texture.image = 0;
  Stage stage(m);
  stage.add_image(1, 1, {255, 10, 1, 255});
  expect(stage, 0.0f, {1000.0f, 1000.0f * 10.0f / 255.0f / 12.92f, 1000.0f / 255.0f / 12.92f}, 0.01f);
}

/// Many texels a pixel: coverage by their mean, and cut-outs by it too.
TEST_F(MaterialRules, AlphaOfMinifiedTexturesIsTheirMean) {
  Material wall = test::matte(glm::vec3(0.0f));
  wall.unlit = true;
  Material m = test::matte(glm::vec3(1.0f));
  m.unlit = true;
  m.base_color_texture.image = 0;
  m.base_color_texture.scale = glm::vec2(40.0f);
  std::vector<std::uint8_t> rgba;
  for (int i = 0; i < 33 * 17; ++i)
    rgba.insert(rgba.end(), {255, 255, 255, static_cast<std::uint8_t>(i % 4 == 0 ? 255 : 40)});
  const float mean = (141.0f * 255.0f + 420.0f * 40.0f) / (561.0f * 255.0f);
  for (const AlphaMode mode : {AlphaMode::blend, AlphaMode::mask}) {
    m.alpha_mode = mode;
    m.alpha_cutoff = 0.3f;  // below the mean, above most texels
    Stage stage(m, &wall);
    stage.add_image(33, 17, rgba);
    expect(stage, 0.0f, glm::vec3(mode == AlphaMode::blend ? mean : 1.0f), 0.01f);
    transport_ = "full";
    EXPECT_NEAR(draw(stage, "reference", 0.0f, 1).x, mode == AlphaMode::blend ? mean : 1.0f, 0.01f);
    transport_ = "direct";
  }
}

/// A coat's normal texture on coordinates of its own has tangents of its own (glTF 2.0, 3.7.2.1), also beside a flat
/// normal texture on others.
TEST_F(MaterialRules, CoatNormalsFollowTheirOwnCoordinates) {
  Material m = test::matte(glm::vec3(0.0f));
  m.clearcoat = 1.0f;
  m.clearcoat_roughness = 0.5f;
  m.clearcoat_normal_texture.image = 0;
  m.clearcoat_normal_texture.uv_set = 1;
  m.clearcoat_normal_texture.rotation_rad = 0.5f;
  sky_ = test::constant_sky(0.1f);
  for (std::size_t i = 0; i < sky_->rgb.size(); ++i)
    if (i % 32 < 16) sky_->rgb[i] = glm::vec3(10.0f);  // towards +x
  const auto stage_of = [](const Material& material) {
    Stage stage(material);
    stage.add_image(1, 1, {210, 128, 220, 255});
    stage.add_image(1, 1, {128, 128, 255, 255});
    stage.scene.meshes[0].primitives[0].uvs[1] = {{0, 0}, {0, 1}, {-1, 0}, {-1, 1}};
    return stage;
  };
  Material both = m, first = m;
  both.normal_texture.image = 1;
  first.clearcoat_normal_texture.uv_set = 0;
  for (const std::string mode : {"uniform", "reference"}) {
    const float alone = draw(stage_of(m), mode, 0.0f, 2048).y, beside = draw(stage_of(both), mode, 0.0f, 2048).y;
    EXPECT_NEAR(beside, alone, 0.02f * alone) << mode;
    EXPECT_GT(std::abs(draw(stage_of(first), mode, 0.0f, 2048).y - alone), 0.06f * alone) << mode;
  }
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
