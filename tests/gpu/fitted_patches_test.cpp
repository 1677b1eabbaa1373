// A mesh mirror while patches are being fitted to it: frames do not wait, and list what is missing.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "render/gl/context.h"
#include "render/renderer.h"
#include "scenes/environment_builtin.h"
#include "scenes/error.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

/// A curved mirror with its own name.
void add_mirror(Scene* scene, const std::string& name, float x, float bend) {
  Primitive p = test::make_grid({x - 0.4f, -0.4f, -1.0f}, {0.8f, 0, 0}, {0, 0.8f, 0}, 12, 0);
  for (std::size_t i = 0; i < p.positions.size(); ++i) {
    glm::vec3& at = p.positions[i];
    const float dx = at.x - x;
    at.z += bend * (dx * dx + 0.5f * at.y * at.y);
    p.normals[i] = glm::normalize(glm::vec3(-2.0f * bend * dx, -bend * at.y, 1.0f));
  }
  test::add(scene, p, name)->reflector = true;
}

Scene two_mirrors(float bend_of_second) {
  Scene scene;
  Material metal;
  metal.name = "mirror";
  metal.metallic = 1.0f;
  metal.roughness = 0.02f;
  scene.materials = {metal};
  add_mirror(&scene, "curved", -0.5f, 0.3f);
  add_mirror(&scene, "second", 0.5f, bend_of_second);
  return scene;
}

FrameRequest bezier_request() {
  FrameRequest r;
  r.mode = "splitsum";
  r.width = 96;
  r.height = 64;
  r.reflections = "bezier";
  r.camera.eye = {0.0f, 0.2f, 1.6f};
  r.camera.target = {0.0f, 0.0f, -1.0f};
  r.camera.fov_y_rad = 0.6f;
  return r;
}

std::string decided_by(const FrameStats& stats, const std::string& what) {
  const auto found = std::find_if(stats.plan.left_out.begin(), stats.plan.left_out.end(),
                                  [&](const LeftOut& l) { return l.what == what; });
  return found == stats.plan.left_out.end() ? "" : found->decided_by;
}

class FittedPatches : public ::testing::Test {
 protected:
  GlContext context_ = GlContext::create_headless();
  Renderer renderer_;
  void SetUp() override { renderer_.set_environment(std::make_shared<Environment>(make_clear_sky())); }
};

TEST_F(FittedPatches, FramesDoNotWaitForThem) {
  renderer_.set_scene(std::make_shared<Scene>(two_mirrors(-0.3f)));
  const FrameStats before = renderer_.render(bezier_request());
  EXPECT_TRUE(before.plan.reflections.empty());
  EXPECT_TRUE(before.status.all_fitting);
  EXPECT_EQ(decided_by(before, "reflections"), "status");
  EXPECT_EQ(before.status.fitting, "'curved', 'second'");
  EXPECT_EQ(decided_by(before, "patch_fit"), "status");
  EXPECT_EQ(before.gpu_bytes.count("reflections"), 0u);
  EXPECT_TRUE(renderer_.finish_background_work(bezier_request()));
  EXPECT_TRUE(renderer_.background_work().empty());
  const FrameStats after = renderer_.render(bezier_request());
  EXPECT_EQ(after.plan.reflections, "bezier");
  EXPECT_EQ(decided_by(after, "patch_fit"), "");
  EXPECT_EQ(after.technique.at("fitted_patches"), 2.0);
}

/// A flat mirror needs no patch.
TEST_F(FittedPatches, OtherMirrorsAreDrawnMeanwhile) {
  renderer_.set_scene(std::make_shared<Scene>(two_mirrors(0.0f)));
  const FrameStats before = renderer_.render(bezier_request());
  EXPECT_EQ(before.plan.reflections, "bezier");
  EXPECT_EQ(before.status.fitting, "'curved'");
  EXPECT_EQ(decided_by(before, "reflections"), "");
  const Image part = renderer_.read_debug_view("reflection");
  renderer_.finish_background_work(bezier_request());
  renderer_.render(bezier_request());
  const Image all = renderer_.read_debug_view("reflection");
  std::size_t of_part = 0, of_all = 0;
  for (std::size_t i = 3; i < all.data.size(); i += 4) {
    of_part += part.data[i] > 0.0f;
    of_all += all.data[i] > 0.0f;
    EXPECT_LE(part.data[i], all.data[i]);
  }
  EXPECT_GT(of_part, 200u);
  EXPECT_GT(of_all, of_part + 200u);
}

/// Averaging restarts when the patches are ready, and not at every frame before.
TEST_F(FittedPatches, ThePictureFollows) {
  renderer_.set_scene(std::make_shared<Scene>(two_mirrors(0.0f)));
  FrameRequest request = bezier_request();
  renderer_.render(request, true);
  renderer_.finish_background_work(request);
  EXPECT_EQ(renderer_.render(request, true).accumulated_frames, 1);
  EXPECT_EQ(renderer_.render(request, true).accumulated_frames, 2);
  // Another technique does not use them.
  std::shared_ptr<Scene> other = std::make_shared<Scene>(two_mirrors(0.2f));
  renderer_.set_scene(other);
  renderer_.render(request, true);
  request.reflections = "off";
  EXPECT_EQ(decided_by(renderer_.render(request, true), "patch_fit"), "");
  EXPECT_TRUE(renderer_.background_work().empty());
}

/// A mesh without area is refused as soon as this is known, and in every frame from then on.
TEST_F(FittedPatches, ARefusalComesLater) {
  Scene scene = two_mirrors(0.2f);
  for (glm::vec3& p : scene.meshes[1].primitives[0].positions) p = {0.5f, p.y, -1.0f};
  renderer_.set_scene(std::make_shared<Scene>(scene));
  EXPECT_NO_THROW(renderer_.render(bezier_request()));
  EXPECT_THROW(renderer_.finish_background_work(bezier_request()), Error);
  EXPECT_THROW(renderer_.render(bezier_request()), Error);
  EXPECT_THROW(renderer_.render(bezier_request()), Error);
}

}  // namespace
}  // namespace maquette
