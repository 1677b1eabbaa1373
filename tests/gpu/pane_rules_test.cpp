// Rules of glTF for what transmits, with closed forms, in every mode and with full transport.
#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "render/math/surface_formulas.h"
#include "tests/gpu/material_stage.h"

namespace maquette {
namespace {

class PaneRules : public MaterialRules {
 protected:
  /// Shows the same in all paths and by the environment alone, as nothing is lit but what is unlit.
  static Material wall() {
    Material m;
    m.base_color = glm::vec4(0.5f, 0.25f, 0.75f, 1.0f);
    m.unlit = true;
    return m;
  }
  static constexpr glm::vec3 kWall{0.5f, 0.25f, 0.75f};

  void expect_in_both(const Stage& stage, float sky, const glm::vec3& value, float relative) {
    expect(stage, sky, value, relative);
    transport_ = "full";
    const glm::vec3 found = draw(stage, "reference", sky, 1024);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], value[c], 0.02f * value[c] + 1e-4f) << "full, channel " << c;
    transport_ = "direct";
  }
};

TEST_F(PaneRules, AlphaCoversWithThePane) {
  const Material behind = wall();
  Material m = test::clear_pane();
  m.base_color = {0.8f, 0.5f, 1.0f, 0.5f};
  m.alpha_mode = AlphaMode::blend;
  Stage stage(m, &behind);
  stage.colors().assign(4, glm::vec4(1.0f, 1.0f, 1.0f, 0.5f));
  glm::vec3 value(0.0f);
  for (int c = 0; c < 3; ++c) {
    const glm::vec2 pane = shared::fresnel_pane(1.0f, 1.5f, m.base_color[c]);
    value[c] = 0.25f * (pane.x * 2.0f + pane.y * kWall[c]) + 0.75f * kWall[c];
  }
  expect_in_both(stage, 2.0f, value, 0.005f);
}

/// What does not transmit is a surface, covered with it.
TEST_F(PaneRules, AlphaCoversWithBothShares) {
  const Material behind = wall();
  Material m = test::matte({0.6f, 0.3f, 0.9f});
  m.glass = true;
  m.transmission = 0.7f;
  m.base_color.a = 0.4f;
  m.alpha_mode = AlphaMode::blend;
  const glm::vec3 color(m.base_color);
  expect(Stage(m, &behind), 1.0f, 0.4f * (0.7f * color * kWall + 0.3f * color) + 0.6f * kWall, 0.01f);
}

/// Panes that blend, and those that are cut out, keep no light away that passes them.
TEST_F(PaneRules, LightPassesPanesThatCoverInPart) {
  for (const AlphaMode mode : {AlphaMode::blend, AlphaMode::mask}) {
    const Material floor = test::matte(glm::vec3(1.0f));
    Material m = test::clear_pane();
    m.alpha_mode = mode;
    m.base_color.a = 0.5f;
    m.alpha_cutoff = 0.2f;
    Stage stage(floor);
    stage.scene.materials.push_back(m);
    test::add(&stage.scene, test::make_grid({-9, -9, 4}, {18, 0, 0}, {0, 18, 0}, 1, 1));  // behind the eye
    stage.add_light(3.14159265f);
    transport_ = "full";
    const float passes = shared::fresnel_pane(1.0f, 1.5f, 1.0f).y;
    EXPECT_NEAR(draw(stage, "reference", 0.0f, 64).x, mode == AlphaMode::blend ? 0.5f + 0.5f * passes : passes, 0.01f);
  }
}

TEST_F(PaneRules, UnlitGlassShowsItsBaseColour) {
  const Material behind = wall();
  Material m = test::clear_pane();
  m.base_color = {0.4f, 0.2f, 0.1f, 1.0f};
  m.unlit = true;
  m.clearcoat = 1.0f;
  m.thickness = 0.3f;
  m.roughness = 0.5f;
  expect_in_both(Stage(m, &behind), 3.0f, {0.4f, 0.2f, 0.1f}, 0.005f);
  m.alpha_mode = AlphaMode::blend;
  m.base_color.a = 0.5f;
  expect_in_both(Stage(m, &behind), 3.0f, 0.5f * glm::vec3(0.4f, 0.2f, 0.1f) + 0.5f * kWall, 0.005f);
}

/// Both faces and all bounces between them, with the F0 of KHR_materials_specular, by factors and textures.
TEST_F(PaneRules, SpecularChangesWhatFacesReflect) {
  const Material behind = wall();
  for (const bool textured : {false, true}) {
    Material m = test::clear_pane();
    m.ior = 1.8f;
    m.specular = 0.6f;
    m.specular_color = {1.0f, 0.5f, 2.0f};
    if (textured) m.specular_texture.image = m.specular_color_texture.image = 0;
    const float share = textured ? 0.6f * 128.0f / 255.0f : 0.6f;
    Stage stage(m, &behind);
    stage.add_image(1, 1, {255, 255, 255, 128});
    glm::vec3 face{};
    for (int c = 0; c < 3; ++c) face[c] = share * std::pow(0.8f / 2.8f, 2.0f) * m.specular_color[c];
    const float passes = 1.0f - face.z;  // the largest of them
    glm::vec3 value{};
    for (int c = 0; c < 3; ++c) {
      const float through = passes * passes / (1.0f - face[c] * face[c]);
      value[c] = face[c] * (1.0f + through) * 2.0f + through * kWall[c];
    }
    expect_in_both(stage, 2.0f, value, 0.01f);
  }
}

/// A tilted, tinted one agrees with the path tracer, which is a slab of two faces too.
TEST_F(PaneRules, TiltedPanesAreTheSameSlabInAllModes) {
  const Material behind = wall();
  Material m = test::clear_pane();
  m.base_color = {0.9f, 0.6f, 0.3f, 1.0f};
  m.specular_color = {0.3f, 1.0f, 0.6f};
  Stage stage(m, &behind);
  for (const float tilt : {0.4f, 0.75f}) {  // mirrors the sky, not the wall
    stage.scene.nodes[0].local = glm::rotate(glm::mat4(1.0f), tilt, glm::vec3(0.0f, 1.0f, 0.0f));
    const shared::PaneShares shares =
        shared::pane_shares(std::cos(tilt), shared::pane_faces(1.5f, 1.0f, m.specular_color), glm::vec3(m.base_color));
    expect_in_both(stage, 1.0f, shares.reflected + shares.transmitted * kWall, 0.02f);
  }
}

/// Solid glass with a closed form: a plate of two faces in the path tracer.
TEST_F(PaneRules, SpecularChangesSolidGlassToo) {
  const Material behind = wall();
  Material m = test::clear_pane();
  m.thickness = 0.1f;
  m.double_sided = true;
  m.specular = 0.5f;
  m.specular_color = {1.0f, 2.0f, 0.5f};
  Stage stage(m, &behind);
  test::add(&stage.scene, test::make_grid({-1, 1, -0.1f}, {2, 0, 0}, {0, -2, 0}, 1, 0));  // its back
  const shared::PaneShares shares =
      shared::pane_shares(1.0f, shared::pane_faces(1.5f, 0.5f, m.specular_color), glm::vec3(1.0f));
  transport_ = "full";
  const glm::vec3 found = draw(stage, "reference", 2.0f, 1024);
  for (int c = 0; c < 3; ++c)
    EXPECT_NEAR(found[c], 2.0f * shares.reflected[c] + shares.transmitted[c] * kWall[c], 0.02f) << c;
}

}  // namespace
}  // namespace maquette
