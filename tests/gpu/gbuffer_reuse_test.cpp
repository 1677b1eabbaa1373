// Reuse of the G-buffer while camera and surfaces do not change: every frame with it equals the same frame drawn
// without reuse, and it is drawn again exactly when something that it depends on has changed.
#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <memory>
#include <string>
#include <utility>
#include <vector>

#include "render/gl/context.h"
#include "render/gl/objects.h"
#include "render/renderer.h"
#include "scenes/error.h"

namespace maquette {
namespace {

Material plain(const std::string& name, const glm::vec4& color) {
  Material m;
  m.name = name;
  m.base_color = color;
  m.metallic = 0.0f;
  m.roughness = 0.6f;
  m.double_sided = true;
  return m;
}

/// A wavy sheet, for its curvature.
Primitive make_sheet(const glm::vec3& corner, int side, int material) {
  Primitive p;
  p.material = material;
  for (int j = 0; j <= side; ++j)
    for (int i = 0; i <= side; ++i) {
      const float x = static_cast<float>(i) / static_cast<float>(side),
                  y = static_cast<float>(j) / static_cast<float>(side);
      p.positions.push_back(corner + glm::vec3(x, y, 0.1f * std::sin(6.0f * x)));
      p.normals.push_back(glm::normalize(glm::vec3(-0.6f * std::cos(6.0f * x), 0.0f, 1.0f)));
    }
  const auto at = [side](int i, int j) { return static_cast<std::uint32_t>(j * (side + 1) + i); };
  for (int j = 0; j < side; ++j)
    for (int i = 0; i < side; ++i)
      p.indices.insert(p.indices.end(),
                       {at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j), at(i + 1, j + 1), at(i, j + 1)});
  return p;
}

/// Two sheets side by side; variant 0 has another material on the left one.
std::shared_ptr<Scene> two_sheets() {
  auto scene = std::make_shared<Scene>();
  scene->materials = {plain("left", {0.6f, 0.3f, 0.2f, 1.0f}), plain("right", {0.2f, 0.3f, 0.6f, 1.0f}),
                      plain("other", {0.1f, 0.7f, 0.1f, 1.0f})};
  scene->variants = {"green"};
  for (int k = 0; k < 2; ++k) {
    Node node;
    node.mesh = k;
    scene->roots.push_back(k);
    scene->nodes.push_back(node);
    scene->meshes.emplace_back();
    scene->meshes.back().primitives.push_back(make_sheet({k == 0 ? -1.05f : 0.05f, -0.5f, 0.0f}, 12, k));
  }
  scene->meshes[0].primitives[0].variant_materials[0] = 2;
  return scene;
}

std::shared_ptr<const Environment> sloping_sky(float slope) {
  auto sky = std::make_shared<Environment>();
  sky->name = "sloping";
  sky->width = 32;
  sky->height = 16;
  for (int i = 0; i < 32 * 16; ++i) sky->rgb.emplace_back(1.0f + static_cast<float>(i % 32) * slope);
  return sky;
}

class KeptGbuffer : public ::testing::Test {
 protected:
  KeptGbuffer() {
    renderer_.set_scene(scene_);
    renderer_.set_environment(sloping_sky(0.1f));
    request_.width = 96;
    request_.height = 64;
    request_.samples = 16;
    request_.camera.eye = {0.1f, 0.2f, 2.0f};
    request_.settings.set_from_text("shading.visibility", "none");
    draw();
  }

  /// Draws with reuse, compares with the same frame drawn without, and returns whether anything was reused.
  bool draw() {
    const FrameStats stats = renderer_.render(request_);
    const Image kept = renderer_.read_radiance();
    FrameRequest without_reuse = request_;
    without_reuse.settings.set("shading.reuse", false);
    const FrameStats full = renderer_.render(without_reuse);
    EXPECT_EQ(kept.data, renderer_.read_radiance().data);
    EXPECT_TRUE(timed(full, "raster") && timed(full, "gbuffer"));
    EXPECT_TRUE(timed(stats, "gbuffer") || !timed(stats, "raster"));
    for (const char* pass : {"raster", "gbuffer"}) {
      const bool said = std::any_of(stats.skipped.begin(), stats.skipped.end(),
                                    [&](const SkippedPass& skipped) { return skipped.name == pass; });
      EXPECT_NE(said, timed(stats, pass)) << "the frame says what it skipped";
    }
    EXPECT_TRUE(take_gl_errors().empty());
    return !timed(stats, "gbuffer");
  }
  static bool timed(const FrameStats& stats, const std::string& pass) {
    return std::any_of(stats.passes.begin(), stats.passes.end(), [&](const PassTime& p) { return p.name == pass; });
  }
  /// Drawn without reuse, so that no point of it is kept either.
  Image picture() {
    FrameRequest without_reuse = request_;
    without_reuse.settings.set("shading.reuse", false);
    renderer_.render(without_reuse);
    return renderer_.read_radiance();
  }

  GlContext context_ = GlContext::create_headless();
  std::shared_ptr<Scene> scene_ = two_sheets();
  Renderer renderer_;
  FrameRequest request_;
};

TEST_F(KeptGbuffer, HoldsWhileOnlyTheLightChanges) {
  EXPECT_TRUE(draw());
  request_.env_rotation_rad = 0.7f;
  EXPECT_TRUE(draw());
  request_.env_scale = 3.0f;
  EXPECT_TRUE(draw());
  request_.seed = 5;
  request_.samples = 32;
  EXPECT_TRUE(draw());
  renderer_.set_environment(sloping_sky(0.3f));
  EXPECT_TRUE(draw());
}

TEST_F(KeptGbuffer, HoldsWhileAMaterialIsSwapped) {
  const auto counts = [&] { return std::pair(renderer_.facts().measured_count, renderer_.facts().analytic_count); };
  EXPECT_EQ(counts(), std::pair(0, 2));
  renderer_.set_material("left", "builtin:paint-red-metallic");
  EXPECT_TRUE(draw());
  EXPECT_EQ(counts(), std::pair(1, 1));
  renderer_.set_material("left", "builtin:rubber-black");
  EXPECT_TRUE(draw());
  renderer_.set_material("other", "builtin:rubber-black");
  EXPECT_EQ(counts(), std::pair(1, 1)) << "nothing seen uses it";
  renderer_.set_material("left", "");
  EXPECT_TRUE(draw());
  EXPECT_EQ(counts(), std::pair(0, 2));
}

TEST_F(KeptGbuffer, FactsFollowARestoredMaterial) {
  scene_ = two_sheets();
  scene_->materials[0].clearcoat = 1.0f;
  scene_->materials[1].roughness = 0.5f;
  renderer_.set_scene(scene_);
  renderer_.set_material("left", "builtin:rubber-black");
  draw();
  EXPECT_FALSE(renderer_.facts().has_clearcoat);
  renderer_.set_material("left", "");
  draw();
  EXPECT_TRUE(renderer_.facts().has_clearcoat);
  EXPECT_EQ(renderer_.facts().least_roughness, 0.0f);
}

TEST_F(KeptGbuffer, ASceneThatCannotBeSetChangesNothing) {
  const Image before = picture();
  auto broken = two_sheets();
  broken->roots.resize(1);
  broken->materials[0].measured = "no-such-file.binary";
  EXPECT_THROW(renderer_.set_scene(broken), Error);
  EXPECT_EQ(picture().data, before.data);
}

TEST_F(KeptGbuffer, AnotherSkyHasTheListOfItsSeed) {
  request_.mode = "uniform";
  request_.seed = 5;
  draw();
  renderer_.set_environment(sloping_sky(0.3f));
  Renderer fresh;
  fresh.set_scene(scene_);
  fresh.set_environment(sloping_sky(0.3f));
  fresh.render(request_);
  EXPECT_EQ(picture().data, fresh.read_radiance().data);
}

TEST_F(KeptGbuffer, IsDrawnAgainWhenASurfaceChanges) {
  renderer_.set_material("right", "builtin:glass");
  EXPECT_FALSE(draw());
  renderer_.set_material("right", "");
  EXPECT_FALSE(draw());
  renderer_.set_node_visible(1, false);
  EXPECT_FALSE(draw());
  renderer_.set_node_visible(1, true);
  EXPECT_FALSE(draw());
  Primitive deformed = scene_->meshes[0].primitives[0];
  for (glm::vec3& p : deformed.positions) p.z += 0.2f * p.y;
  renderer_.update_mesh(0, deformed.positions, deformed.normals);
  EXPECT_FALSE(draw());
  auto recoloured = two_sheets();
  recoloured->materials[0].base_color = {0.9f, 0.9f, 0.1f, 1.0f};
  renderer_.set_scene(recoloured);
  EXPECT_FALSE(draw());
}

TEST_F(KeptGbuffer, IsDrawnAgainWhenTheViewChanges) {
  request_.camera.eye.x += 0.01f;
  EXPECT_FALSE(draw());
  request_.camera.fov_y_rad *= 1.1f;
  EXPECT_FALSE(draw());
  request_.width = 80;
  EXPECT_FALSE(draw());
  request_.msaa = 4;
  EXPECT_FALSE(draw());
  EXPECT_TRUE(draw());
  request_.mode = "uniform";  // which has a G-buffer of its own, of the same triangles
  EXPECT_FALSE(draw());
  EXPECT_TRUE(draw());
}

/// A window presents the picture between two frames, which draws other triangles.
TEST_F(KeptGbuffer, MirrorsShowTheSameAfterThePictureWasShown) {
  scene_ = two_sheets();
  scene_->materials[1].metallic = 1.0f;
  scene_->materials[1].roughness = 0.02f;
  scene_->nodes[1].name = "mirror";
  scene_->nodes[0].local[3] = {0.6f, 0.0f, 1.0f, 1.0f};
  renderer_.set_scene(scene_);
  request_.reflections = "raytraced";
  request_.reflectors = {"mirror"};
  request_.settings.set("shading.reuse", false);  // rays are traced again
  renderer_.render(request_);
  const Image before = renderer_.read_debug_view("reflection_distance");
  ASSERT_GT(*std::max_element(before.data.begin(), before.data.end()), 0.5f) << "the mirror shows the other sheet";
  const Texture window = Texture::make_2d("window", GL_RGBA8, 96, 64);
  GLuint name = 0;
  glCreateFramebuffers(1, &name);
  const GlName<FramebufferTraits> framebuffer(name);
  glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, window.get(), 0);
  glBindFramebuffer(GL_FRAMEBUFFER, name);
  renderer_.present(0, 0, 96, 64, 0.0f, "linear");
  renderer_.render(request_, true);
  EXPECT_EQ(before.data, renderer_.read_debug_view("reflection_distance").data);
}

TEST_F(KeptGbuffer, FollowsTheVariantThroughSwaps) {
  const Image first = picture();
  request_.variant = 0;
  EXPECT_FALSE(draw());
  EXPECT_NE(first.data, picture().data);
  // A swap while a variant is on must not keep the variant when it is turned off again.
  renderer_.set_material("right", "builtin:rubber-black");
  EXPECT_TRUE(draw());
  renderer_.set_material("right", "");
  request_.variant = -1;
  EXPECT_FALSE(draw());
  EXPECT_EQ(first.data, picture().data);
}

/// Three wavy panes of different tints, each in front of a part of the next, over a wall that fills half of the view.
std::shared_ptr<Scene> three_panes() {
  auto scene = std::make_shared<Scene>();
  scene->materials = {plain("wall", {0.6f, 0.3f, 0.2f, 1.0f})};
  for (int k = 0; k < 4; ++k) {
    if (k > 0) {
      scene->materials.push_back(plain("pane", {0.4f + 0.2f * static_cast<float>(k), 0.9f, 0.7f, 1.0f}));
      scene->materials.back().glass = true;
      scene->materials.back().transmission = 1.0f;
      scene->materials.back().ior = 1.5f;
    }
    Node node;
    node.mesh = k;
    scene->roots.push_back(k);
    scene->nodes.push_back(node);
    scene->meshes.emplace_back();
    const float x = k == 0 ? -1.0f : -0.9f + 0.3f * static_cast<float>(k),
                z = k == 0 ? -0.5f : 0.2f * static_cast<float>(k);
    scene->meshes.back().primitives.push_back(make_sheet({x, -0.5f, z}, 12, k));
  }
  return scene;
}

TEST_F(KeptGbuffer, KeptPanesLookLikeDrawnOnes) {
  renderer_.set_scene(three_panes());
  request_.mode = "uniform";
  const auto compare = [&](bool kept) {
    const FrameStats stats = renderer_.render(request_);
    const Image picture = renderer_.read_radiance();
    FrameRequest without_reuse = request_;
    without_reuse.settings.set("shading.reuse", false);
    const FrameStats full = renderer_.render(without_reuse);
    const Image drawn = renderer_.read_radiance();
    // Only a software device keeps them: others do not promise the order of fragments.
    if (kept && query_device().software) {
      EXPECT_GT(stats.gpu_bytes.at("glass"), full.gpu_bytes.at("glass"));
    }
    double apart = 0.0;
    for (std::size_t i = 0; i < drawn.data.size(); ++i)
      apart = std::max(apart, std::abs(static_cast<double>(picture.data[i]) - drawn.data[i]) / (1.0 + drawn.data[i]));
    EXPECT_LT(apart, 1e-5);
  };
  compare(false);
  for (const float eye : {0.1f, 2.0f, -6.0f}) {  // the last two look along the panes, which cover themselves
    request_.camera.eye.x = eye;
    compare(false);
    for (const float rotation : {0.0f, 0.7f, 2.0f}) {
      request_.env_rotation_rad = rotation;
      compare(true);
    }
  }
  request_.env_scale = 3.0f;
  compare(true);
  request_.msaa = 4;
  compare(false);
  request_.env_scale = 2.0f;
  compare(true);
  renderer_.set_node_visible(2, false);
  compare(false);
  request_.env_rotation_rad = 1.0f;
  compare(true);
  request_.msaa = 1;
  request_.samples = 4;
  request_.width = request_.height = 1408;  // lists of tiles of two bands of rows
  compare(false);
  request_.env_rotation_rad = 2.0f;
  compare(true);
}

}  // namespace
}  // namespace maquette
