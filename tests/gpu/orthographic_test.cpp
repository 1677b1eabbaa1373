// Orthographic cameras against closed forms: what is where in the picture, whatever its depth and the eye's distance.
#include <gtest/gtest.h>

#include "render/gl/context.h"
#include "render/renderer.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

constexpr int kOrthographicSide = 40;

class Orthographic : public ::testing::Test {
 protected:
  static Material glowing(const glm::vec3& color) {
    Material m = test::matte(glm::vec3(0.0f));
    m.emissive = color;
    m.double_sided = true;
    return m;
  }

  static FrameRequest request(const std::string& mode) {
    FrameRequest r;
    r.mode = mode;
    r.width = r.height = kOrthographicSide;
    r.samples = 16;
    r.camera.eye = {0.0f, 0.0f, 4.0f};
    r.camera.target = glm::vec3(0.0f);
    r.camera.height_m = 2.0f;
    return r;
  }

  Image draw(const FrameRequest& r) {
    renderer_.finish_background_work(r);
    renderer_.render(r);
    const auto errors = take_gl_errors();
    EXPECT_TRUE(errors.empty()) << errors.front();
    return renderer_.read_radiance();
  }

  GlContext context_ = GlContext::create_headless();
  Renderer renderer_;
};

/// Red left of the middle at z = 0, green right of it at z = -5: of equal size in the picture.
TEST_F(Orthographic, EqualLengthsAreEqualAtEveryDepth) {
  Scene scene;
  scene.materials = {glowing({1, 0, 0}), glowing({0, 1, 0})};
  test::add(&scene, test::make_grid({-0.5f, -0.5f, 0.0f}, {0.5f, 0, 0}, {0, 1, 0}, 1, 0));
  test::add(&scene, test::make_grid({0.0f, -0.5f, -5.0f}, {0.5f, 0, 0}, {0, 1, 0}, 1, 1));
  renderer_.set_scene(std::make_shared<Scene>(scene));
  renderer_.set_environment(test::constant_sky(0.0f));
  for (const char* mode : {"uniform", "bandwidth", "splitsum", "sg", "reference"})
    for (const float distance : {4.0f, 4e6f, 1.0f}) {
      FrameRequest r = request(mode);
      r.camera.eye.z = distance;
      const Image image = draw(r);
      for (int y = 0; y < kOrthographicSide; ++y)
        for (int x = 0; x < kOrthographicSide; ++x) {
          const bool within = y >= 10 && y < 30;
          // A path tracer's pixel on the border may show either.
          if (r.mode == "reference" && (x % 10 == 0 || x % 10 == 9 || y % 10 == 0 || y % 10 == 9)) continue;
          EXPECT_NEAR(image.at(x, y, 0), within && x >= 10 && x < 20 ? 1.0f : 0.0f, 1e-3f)
              << mode << " from " << distance << " at " << x << ", " << y;
          EXPECT_NEAR(image.at(x, y, 1), within && x >= 20 && x < 30 ? 1.0f : 0.0f, 1e-3f)
              << mode << " from " << distance << " at " << x << ", " << y;
        }
    }
}

TEST_F(Orthographic, NothingBehindTheEyeIsSeen) {
  Scene scene;
  scene.materials = {glowing({1, 0, 0}), glowing({0, 1, 0})};
  test::add(&scene, test::make_grid({-0.5f, -0.5f, 5.0f}, {1, 0, 0}, {0, 1, 0}, 1, 0));
  test::add(&scene, test::make_grid({-0.5f, -0.5f, 0.0f}, {1, 0, 0}, {0, 1, 0}, 1, 1));
  renderer_.set_scene(std::make_shared<Scene>(scene));
  renderer_.set_environment(test::constant_sky(0.0f));
  for (const char* mode : {"uniform", "reference"}) {
    const Image image = draw(request(mode));
    EXPECT_EQ(image.at(20, 20, 0), 0.0f) << mode;
    EXPECT_NEAR(image.at(20, 20, 1), 1.0f, 1e-3f) << mode;
  }
}

/// The picked point is where the pixel is, at the depth of what it shows.
TEST_F(Orthographic, PicksWhatThePixelShows) {
  Scene scene;
  scene.materials = {glowing({1, 0, 0})};
  test::add(&scene, test::make_grid({-2, -2, -5}, {4, 0, 0}, {0, 4, 0}, 1, 0));
  renderer_.set_scene(std::make_shared<Scene>(scene));
  renderer_.set_environment(test::constant_sky(0.0f));
  for (const char* mode : {"uniform", "reference"}) {
    draw(request(mode));
    const Renderer::Pick pick = renderer_.pick(30, 5);
    ASSERT_TRUE(pick.hit) << mode;
    EXPECT_LT(glm::distance(pick.position, glm::vec3((30.5f / 20.0f) - 1.0f, 1.0f - (5.5f / 20.0f), -5.0f)), 1e-4f);
  }
}

/// A mirror at 45 degrees shows a square beside it in its true size.
TEST_F(Orthographic, MirrorsShowTrueLengths) {
  Scene scene;
  Material mirror = test::matte(glm::vec3(0.0f));
  mirror.base_color = glm::vec4(1.0f);
  mirror.metallic = 1.0f;
  mirror.roughness = 0.0f;
  mirror.specular = 1.0f;
  mirror.double_sided = true;
  scene.materials = {glowing({1, 0, 0}), mirror};
  test::add(&scene, test::make_grid({3.0f, -0.3f, -0.3f}, {0, 0, 0.6f}, {0, 0.6f, 0}, 4, 0));
  test::add(&scene, test::make_grid({-0.8f, -0.8f, 0.8f}, {1.6f, 0, -1.6f}, {0, 1.6f, 0}, 4, 1), "mirror")->reflector =
      true;
  renderer_.set_scene(std::make_shared<Scene>(scene));
  renderer_.set_environment(test::constant_sky(0.0f));
  const auto check = [&](const Image& image, const std::string& what, float tolerance) {
    for (const int x : {10, 16, 20, 24, 30})
      for (const int y : {10, 16, 20, 24, 30}) {
        const bool seen = x > 14 && x < 26 && y > 14 && y < 26;
        EXPECT_NEAR(image.at(x, y, 0), seen ? 1.0f : 0.0f, tolerance) << what << " at " << x << ", " << y;
      }
  };
  for (const char* technique : {"raytraced", "octree"}) {
    FrameRequest r = request("uniform");
    r.reflections = technique;
    r.settings.set_from_text("reflections.resolution", "full");
    check(draw(r), technique, 0.05f);
  }
  check(draw(request("reference")), "reference", 0.05f);
}

TEST_F(Orthographic, TechniquesThatProjectFromAnEyeAreLeftOut) {
  Scene scene;
  scene.materials = {glowing({1, 0, 0})};
  scene.materials[0].glass = true;
  test::add(&scene, test::make_grid({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 1, 0), "pane");
  renderer_.set_scene(std::make_shared<Scene>(scene));
  renderer_.set_environment(test::constant_sky(1.0f));
  for (const char* technique : {"bezier", "triangle"}) {
    FrameRequest r = request("uniform");
    r.reflections = technique;
    r.reflectors = {"pane"};
    renderer_.finish_background_work(r);
    const FrameStats stats = renderer_.render(r);
    EXPECT_TRUE(stats.plan.reflections.empty());
    const bool said = std::any_of(stats.plan.left_out.begin(), stats.plan.left_out.end(), [](const LeftOut& l) {
      return l.what == "reflections" && l.why.find("orthographic") != std::string::npos;
    });
    EXPECT_TRUE(said) << technique;
  }
}

}  // namespace
}  // namespace maquette
