// The exposure of a window that is lit stays that of what it shows (viewer/window_session): when bakes end, and after
// another environment, intensity, paint or scene.
#include <gtest/gtest.h>

#include <cmath>

#include "render/gl/context.h"
#include "scenes/modelling.h"
#include "tests/scenes/temporary_folder.h"
#include "tests/support/test_scenes.h"
#include "tests/support/waiting.h"
#include "viewer/window_session.h"

namespace maquette {
namespace {

constexpr int kMeterWidth = 96, kMeterHeight = 64;

class WindowExposure : public test::TemporaryFolder {
 protected:
  std::string stored(const std::string& name, const Scene& scene) {
    const std::string file = path(name + ".glb");
    save_glb(file, scene);
    return file;
  }
  static SceneOptions options(const std::string& scene) {
    SceneOptions result;
    result.scene = scene;
    result.screenshot = "none.png";  // such a window leaves no journal
    result.environment = "builtin:studio";
    result.settings.set("uniform.samples", 16);
    result.mode = "uniform";
    result.settings_given = {"ground.kind"};
    return result;
  }
  /// Draws the next frame and meters as the window does.
  static void step(WindowSession* session) {
    session->update(false, 0.0);
    const FrameStats stats = session->renderer().render(session->make_frame_request(kMeterWidth, kMeterHeight), true);
    session->meter_if_requested(stats.accumulated_frames > 1);
  }
  /// The exposure once everything has been read and baked and the picture rests.
  static float settled_ev(WindowSession* session) {
    for (int rests = 0; rests < 8; ++rests) {
      EXPECT_TRUE(test::comes_true([&] {
        session->update(false, 0.0);
        if (session->loading()) rests = 0;
        return !session->loading();
      }));
      session->renderer().finish_background_work(session->make_frame_request(kMeterWidth, kMeterHeight));
      step(session);
    }
    return session->state.exposure_ev;
  }
  /// Of a window that is opened so.
  static float opened_ev(const SceneOptions& options) {
    WindowSession session(options);
    return settled_ev(&session);
  }

  GlContext context_ = GlContext::create_headless();
};

/// In a room without a roof: the sky lights all of it until its shadows are there.
TEST_F(WindowExposure, FollowsBakesThatEnd) {
  const std::string file = stored("room", test::box_scene(5, 4, test::matte(glm::vec3(0.1f))));
  SceneOptions inside = options(file);
  inside.eye = glm::vec3(0.3f, 0.1f, 0.2f);
  inside.target = glm::vec3(-1.0f, -0.6f, -0.7f);
  WindowSession session(inside);
  step(&session);
  const float before = session.state.exposure_ev, after = settled_ev(&session);
  EXPECT_GT(after, before + 0.5f) << "shadows darken the room";
  EXPECT_NEAR(after, opened_ev(inside), 0.1);
}

TEST_F(WindowExposure, FollowsIntensityEnvironmentAndPaint) {
  Material grey = test::matte(glm::vec3(0.5f));
  grey.name = "paint";
  const std::string file = stored("walls", test::box_scene(3, 4, grey));
  WindowSession session(options(file));
  const float first = settled_ev(&session);

  session.state.edits.env_scale = 900.0f;
  EXPECT_NEAR(settled_ev(&session), first - std::log2(900.0), 0.02) << "an intensity of 900";
  session.state.edits.env_scale = 1.0f;
  EXPECT_NEAR(settled_ev(&session), first, 0.02);

  SceneOptions other = options(file);
  other.environment = "builtin:clear-sky";
  const float under_sky = opened_ev(other);
  EXPECT_GT(std::abs(under_sky - first), 1.0f);
  session.open("builtin:clear-sky", -1);
  EXPECT_NEAR(settled_ev(&session), under_sky, 0.1) << "another environment";
  session.open("builtin:studio", -1);
  EXPECT_NEAR(settled_ev(&session), first, 0.1);

  SceneOptions painted = options(file);
  painted.materials = {{"paint", "builtin:leather-black"}};
  const float black = opened_ev(painted);
  EXPECT_GT(std::abs(black - first), 0.5f);
  session.state.edits.materials["paint"] = "builtin:leather-black";
  EXPECT_NEAR(settled_ev(&session), black, 0.1) << "another paint";
}

TEST_F(WindowExposure, FollowsTheScene) {
  const std::string bright = stored("bright", test::box_scene(3, 4, test::matte(glm::vec3(0.9f)))),
                    dark = stored("dark", test::box_scene(3, 4, test::matte(glm::vec3(0.02f))));
  WindowSession session(options(bright));
  settled_ev(&session);
  session.open(dark, -1);
  SceneOptions other = options(dark);
  other.settings_given.clear();  // as it is opened in a window that runs
  const float expected = opened_ev(other);
  EXPECT_NEAR(settled_ev(&session), expected, 0.1);
}

TEST_F(WindowExposure, StaysWhereItIsNotLit) {
  const std::string file = stored("walls", test::box_scene(3, 4, test::matte(glm::vec3(0.5f))));
  SceneOptions fixed = options(file);
  fixed.exposure_ev = -3.0f;
  WindowSession session(fixed);
  session.state.auto_exposure = false;
  session.state.edits.env_scale = 900.0f;
  EXPECT_EQ(settled_ev(&session), -3.0f);
}

}  // namespace
}  // namespace maquette
