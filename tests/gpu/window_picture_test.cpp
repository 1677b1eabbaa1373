// How coarse the window draws (viewer/window_picture): at first of another look, and while a path plays.
#include "viewer/window_picture.h"

#include <gtest/gtest.h>

#include "render/gl/context.h"
#include "tests/scenes/temporary_folder.h"
#include "tests/support/test_scenes.h"
#include "tests/support/waiting.h"
#include "viewer/window_session.h"

namespace maquette {
namespace {

class WindowPictures : public test::TemporaryFolder {
 protected:
  static constexpr int kWidth = 160, kHeight = 100;

  /// A turn of the window's loop at this time; the width of what was drawn, 0 where nothing was.
  int turn(WindowSession* session, double now_s, bool playing = false) {
    session->update(playing, now_s);
    PictureUpdate update;
    update.width_px = kWidth;
    update.height_px = kHeight;
    update.now_s = now_s;
    update.playing = playing;
    return picture_.update(session, update) ? picture_.drawn_size().x : 0;
  }
  SceneOptions options() {
    save_glb(path("ball.glb"), test::sphere_of(test::matte(glm::vec3(0.5f))));
    SceneOptions result;
    result.scene = path("ball.glb");
    result.screenshot = "none.png";  // such a window leaves no journal
    result.environment = "builtin:studio";
    result.mode = "uniform";
    result.settings.set("uniform.samples", 4);
    return result;
  }

  GlContext context_ = GlContext::create_headless();
  WindowPicture picture_;
};

TEST_F(WindowPictures, NothingIsRefinedWhileAPathRestsAtAKey) {
  WindowSession session(options());
  session.state.moving_scale = 0.5f;
  EXPECT_EQ(turn(&session, 0.0), kWidth);
  double now_s = 10.0;
  session.state.camera.eye.x += 0.1f;
  EXPECT_EQ(turn(&session, now_s, true), kWidth / 2);
  for (int i = 0; i < 20; ++i) {  // two seconds at a key
    const int drawn = turn(&session, now_s += 0.1, true);
    EXPECT_TRUE(drawn == 0 || drawn == kWidth / 2) << "a slow frame would be late for the move: " << drawn;
  }
  session.state.camera.eye.x += 0.1f;
  EXPECT_EQ(turn(&session, now_s += 0.1, true), kWidth / 2);
  EXPECT_EQ(turn(&session, now_s += 1.0), kWidth) << "the path has ended";
}

TEST_F(WindowPictures, AnErrorLeavesTheModesOfPartsAsTheyWereChosen) {
  Scene scene;
  scene.materials = {test::matte(glm::vec3(0.5f))};
  test::add(&scene, test::make_grid({-1, -1, 0}, {1, 0, 0}, {0, 2, 0}, 2, 0), "left");
  test::add(&scene, test::make_grid({0, -1, 0}, {1, 0, 0}, {0, 2, 0}, 2, 0), "right");
  SceneOptions two = options();
  two.scene = path("two.glb");
  save_glb(two.scene, scene);
  WindowSession session(two);
  session.state.mode = "slf";  // one part alone: the request leaves the other to the default mode
  session.state.settings.set("slf.parts", std::string("left"));
  session.state.settings.set("slf.run", std::string("hold"));
  session.state.edits.part_modes = {{"right", "sg"}};
  EXPECT_EQ(turn(&session, 0.0), kWidth);
  const Edits chosen = session.state.edits;
  session.state.edits.reflectors = {"nobody"};
  EXPECT_EQ(turn(&session, 10.0), 0) << "an error";
  EXPECT_EQ(session.state.edits, chosen);
  EXPECT_EQ(session.state.mode, "slf");
}

TEST_F(WindowPictures, AnotherLookIsShownCoarselyOnlyWhereFramesAreSlow) {
  WindowSession session(options());
  session.state.settings.set("uniform.samples", 32);
  turn(&session, 0.0);
  Look other = session.state;
  other.name = "other";
  other.camera.eye.x += 0.2f;
  for (const bool slow : {false, true}) {
    const auto limit = slow ? 0.0 : 1e9;
    picture_.set_slow_look_ms(limit);
    session.take(other);
    const int first = turn(&session, slow ? 20.0 : 10.0);
    EXPECT_EQ(first < kWidth / 2, slow) << first;
    EXPECT_EQ(picture_.drawn().samples, slow ? 16 : 0);
    if (slow) {
      EXPECT_EQ(turn(&session, 20.001), kWidth) << "and as it is wanted right after that";
      EXPECT_EQ(picture_.drawn().samples, 0);
    }
    other.camera.eye.x += 0.2f;
  }
  session.state.camera.eye.x += 0.2f;
  session.state.moving_scale = 0.7f;
  EXPECT_EQ(turn(&session, 30.0), static_cast<int>(0.7f * kWidth)) << "a move of the camera is no other look";
}

TEST_F(WindowPictures, WhatABakeBringsIsShownBeforeItsEdgesAreSmoothed) {
  SceneOptions with_bake = options();
  with_bake.mode = "slf";
  with_bake.settings = Settings();
  with_bake.settings.set("slf.texels", 32);
  with_bake.settings.set("slf.paths", 4);
  WindowSession session(with_bake);
  session.state.still_msaa = 4;
  double now_s = 0.0;
  turn(&session, now_s);
  int rested = 0;
  ASSERT_TRUE(test::comes_true([&] {
    if (session.renderer().background_work().empty()) return true;
    ++rested;
    turn(&session, now_s += 0.5);
    return false;
  }));
  ASSERT_GT(rested, 4) << "the preview rests meanwhile";
  EXPECT_EQ(turn(&session, now_s += 0.5), kWidth);
  EXPECT_EQ(picture_.drawn().msaa, 1);
}

}  // namespace
}  // namespace maquette
