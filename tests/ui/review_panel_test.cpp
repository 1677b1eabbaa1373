// Looks, paths and their timeline in the tab Review, without a window.
#include <gtest/gtest.h>

#include "tests/ui/headless_editor.h"
#include "tests/ui/small_scene.h"

namespace maquette {
namespace {

using test::HeadlessEditor;
using test::small_scene;

TEST(ReviewPanel, APathBeginsInItsLookWhicheverKeyIsFirst) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 1400.0f);
  editor.facts.scene = &scene;
  CameraPath path;
  path.name = "way";
  path.keys.resize(3);
  for (std::size_t i = 0; i < 3; ++i) path.keys[i].name = std::string(1, static_cast<char>('a' + i));
  path.keys[0].look = "red";
  editor.state.paths = {path};
  editor.state.left_tab = 3;
  editor.step(3);
  ASSERT_TRUE(editor.click("key/remove/a"));
  const std::vector<PathKey>& keys = editor.state.paths[0].keys;
  ASSERT_EQ(keys.size(), 2u);
  EXPECT_EQ(keys[0].look, "red");
  ASSERT_TRUE(editor.click("key/up/c"));
  EXPECT_EQ(keys[0].name, "c");
  EXPECT_EQ(keys[0].look, "red");
}

TEST(ReviewPanel, AKeyIsDraggedAlongTheTimeline) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 1400.0f);
  editor.facts.scene = &scene;
  CameraPath path;
  path.name = "way";
  path.keys.resize(3);
  path.keys[1].camera.eye.x = 1.0f;
  path.keys[2].camera.eye.x = 2.0f;
  editor.state.paths = {path};
  editor.state.left_tab = 3;
  editor.step(3);
  const Rect first = editor.frame.items.at("timeline/1"), second = editor.frame.items.at("timeline/2");
  const float two_seconds = second.x - first.x;
  ASSERT_GT(two_seconds, 20.0f);
  ASSERT_TRUE(editor.drag("timeline/2", 0.5f * two_seconds, 0.0f));
  const std::vector<double> times = key_times_s(editor.state.paths[0]);
  EXPECT_NEAR(times[1], 3.0, 0.1);
  EXPECT_NEAR(times[2], 4.0, 1e-9) << "its neighbours stay";
  EXPECT_EQ(editor.state.path_view.key, 1) << "it is the chosen one";
  EXPECT_NEAR(editor.state.path_view.time_s, times[1], 1e-9) << "the picture shows it";
  ASSERT_TRUE(editor.drag("timeline/3", 0.25f * two_seconds, 0.0f));
  EXPECT_NEAR(path_duration_s(editor.state.paths[0]), 4.5, 0.1) << "the last one makes the path longer";
  ASSERT_TRUE(editor.click("timeline/1"));
  EXPECT_EQ(editor.state.path_view.key, 0);
  EXPECT_EQ(editor.state.path_view.time_s, 0.0);
}

/// In a slow frame the way of the mouse and its release come together.
TEST(ReviewPanel, AKeyIsDraggedWithinOneFrame) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 1400.0f);
  editor.facts.scene = &scene;
  CameraPath path;
  path.name = "way";
  path.keys.resize(3);
  editor.state.paths = {path};
  editor.state.left_tab = 3;
  editor.step(3);
  const Rect first = editor.frame.items.at("timeline/1"), second = editor.frame.items.at("timeline/2");
  ImGuiIO& io = ImGui::GetIO();
  io.MousePos = {second.x + 0.5f * second.width, second.y + 0.5f * second.height};
  editor.step();
  io.MouseDown[0] = true;
  editor.step();
  io.MousePos.x += 0.5f * (second.x - first.x);
  io.MouseDown[0] = false;
  editor.step();
  EXPECT_NEAR(key_times_s(editor.state.paths[0])[1], 3.0, 0.1);
  editor.step(3);
  EXPECT_NEAR(key_times_s(editor.state.paths[0])[1], 3.0, 0.1) << "and stays";
}

TEST(ReviewPanel, LateFramesDoNotMoveTheKeys) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 1400.0f);
  editor.facts.scene = &scene;
  CameraPath path;
  path.name = "way";
  path.keys.resize(2);
  path.keys[1].camera.eye.x = 1.0f;
  editor.state.paths = {path};
  editor.state.left_tab = 3;
  editor.step(3);
  const float before = editor.frame.items.at("key/1").y;
  editor.state.path_view.late_frames = 1234;
  editor.step(3);
  EXPECT_EQ(editor.frame.items.at("key/1").y, before);
}

TEST(ReviewPanel, ALookHasANote) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 720.0f);
  editor.facts.scene = &scene;
  editor.state.name = "day";
  editor.state.looks = {editor.state};
  editor.state.left_tab = 3;
  editor.step(3);
  ASSERT_TRUE(editor.click("look note"));
  ImGui::GetIO().AddInputCharactersUTF8("too dark");
  editor.step(2);
  EXPECT_EQ(editor.state.looks[0].note, "too dark");
  EXPECT_EQ(editor.state.note, "too dark");
}

}  // namespace
}  // namespace maquette
