// Paths as the window makes and plays them (viewer/window_paths).
#include "viewer/window_paths.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <memory>

#include "render/gl/context.h"
#include "tests/scenes/temporary_folder.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

class WindowsPaths : public test::TemporaryFolder {
 protected:
  void SetUp() override {
    TemporaryFolder::SetUp();
    save_glb(path("ball.glb"), test::sphere_of(test::matte(glm::vec3(0.5f))));
    SceneOptions options;
    options.scene = path("ball.glb");
    options.screenshot = "none.png";  // such a window leaves no journal
    options.environment = "builtin:studio";
    session_ = std::make_unique<WindowSession>(options);
  }
  void carry_out(bool EditorActions::*action) {
    EditorActions actions;
    actions.*action = true;
    paths_.carry_out(actions, session_.get(), now_s_);
  }
  EditorState& state() { return session_->state; }
  /// The path at this time, as the bar below the picture goes there.
  void go_to(double time_s) {
    state().path_view.time_s = time_s;
    state().path_view.goes_there = true;
    paths_.update(session_.get(), now_s_ += 1.0);
  }

  GlContext context_ = GlContext::create_headless();
  std::unique_ptr<WindowSession> session_;
  WindowPaths paths_;
  double now_s_ = 0.0;
};

TEST_F(WindowsPaths, AreTheSameFromWhateverIsAtHand) {
  state().edits.env_scale = 2.0f;
  carry_out(&EditorActions::turntable);
  ASSERT_EQ(state().paths.size(), 1u);
  ASSERT_EQ(state().looks.size(), 1u) << "what the path is seen in is kept";
  EXPECT_EQ(state().paths[0].keys[0].look, state().looks[0].name);
  go_to(1.0);
  const Look first = state();
  EXPECT_EQ(first.edits.env_scale, 2.0f);

  state().edits.env_scale = 7.0f;  // the look's name stays
  state().mode = "splitsum";
  go_to(1.0);
  EXPECT_EQ(static_cast<const Look&>(state()), first);
  state().name = "another";
  state().tonemap = "linear";
  go_to(1.0);
  EXPECT_EQ(static_cast<const Look&>(state()), first);
}

TEST_F(WindowsPaths, NameTheLookThatIsKeptAlready) {
  carry_out(&EditorActions::keep_look);
  state().camera.eye.x += 0.5f;  // which the path moves
  carry_out(&EditorActions::new_path);
  carry_out(&EditorActions::add_key);
  carry_out(&EditorActions::turntable);
  EXPECT_EQ(state().looks.size(), 1u);
  for (const CameraPath& path : state().paths) EXPECT_EQ(path.keys[0].look, state().looks[0].name);
  EXPECT_FALSE(state().paths[0].keys[1].look) << "as before";
}

TEST_F(WindowsPaths, OneWithoutKeysIsWrittenAsItIs) {
  carry_out(&EditorActions::new_path);
  state().paths[0].keys.clear();
  carry_out(&EditorActions::export_path);
  EXPECT_TRUE(std::filesystem::remove("path.path.json"));
}

TEST_F(WindowsPaths, WhatIsChangedByHandWhileOnePlaysStays) {
  carry_out(&EditorActions::turntable);
  carry_out(&EditorActions::play_path);
  paths_.update(session_.get(), now_s_ += 0.1);
  state().mode = "splitsum";
  paths_.update(session_.get(), now_s_ += 0.1);
  EXPECT_EQ(state().mode, "splitsum");
  EXPECT_TRUE(paths_.playing());
}

}  // namespace
}  // namespace maquette
