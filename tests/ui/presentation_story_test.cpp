// The presentation story in the real window: a camera path is recorded, edited, played, written, and rendered.
#include <gtest/gtest.h>

#include <cstdlib>

#include "tests/ui/story_fixture.h"

namespace maquette {
namespace {

class PresentationStory : public Story {
 protected:
  bool camera_comes_to(const CameraView& wanted) {
    return wait_for_review([&](const Review& r) { return glm::distance(r.look.camera.eye, wanted.eye) < 1e-3f; });
  }
};

TEST_F(PresentationStory, RecordEditPlayExport) {
  const Scene scene = load_scene("builtin:sphere");
  Controls at = controls(scene);
  const Rect picture = at.picture(), middle = middle_of(picture);
  begin({"builtin:sphere"});
  ASSERT_TRUE(wait_for_picture(middle)) << desktop_->errors();
  const std::string file = (folder_ / "show.maquette.json").string();
  key("ctrl+s");
  desktop_->input({"type", "--delay", "1", file});
  key("Return");
  ASSERT_TRUE(wait_for_file(file)) << desktop_->errors();
  file_ = file;
  const ScreenPicture before = desktop_->grab();
  desktop_->click(at.item("tab/Review"));
  at.state().left_tab = 3;
  ASSERT_TRUE(wait_for_change(before, at.item("path/record"), 1.0)) << "the tab opens";
  press(&at, "section/Looks");

  desktop_->click(at.item("path/record"));
  const float x = picture.x + 0.3f * picture.width, y = picture.y + 0.4f * picture.height;
  desktop_->move(x, y);
  desktop_->input({"mousedown", "1"});
  for (int i = 1; i <= 12; ++i) desktop_->move(x + 0.03f * static_cast<float>(i) * picture.width, y);
  desktop_->input({"mouseup", "1"});
  desktop_->click(at.item("path/record"));
  ASSERT_TRUE(wait_for_review([](const Review& r) { return r.paths.size() == 1; })) << desktop_->errors();
  CameraPath path = review()->paths[0];
  ASSERT_GE(path.keys.size(), 2u);
  EXPECT_GT(glm::distance(path.keys.front().camera.eye, path.keys.back().camera.eye), 0.3f);

  at.state().paths = review()->paths;
  desktop_->click(at.item("key/1"));
  at.state().path_view.key = 0;
  EXPECT_TRUE(camera_comes_to(path.keys.front().camera)) << "the key is shown";
  const Rect delay = at.item("key/Delay");
  desktop_->move(delay.x + 0.5f * delay.width, delay.y + 0.5f * delay.height);
  desktop_->input({"keydown", "ctrl", "click", "1", "keyup", "ctrl", "type", "--delay", "1", "1.5"});
  key("Return");
  EXPECT_TRUE(wait_for_review([](const Review& r) { return r.paths[0].keys[0].delay_s == 1.5; }))
      << "Ctrl+click types a value";
  path = review()->paths[0];
  keep_screen("presentation-path");

  desktop_->click(at.item("path/play"));
  EXPECT_TRUE(camera_comes_to(path.keys.back().camera)) << "it is played to its end";
  desktop_->click(at.item("path/" + path.name));
  at.state().path_view.key = -1;
  press(&at, "path/export");
  const std::string written = (folder_ / (path.name + ".path.json")).string();
  ASSERT_TRUE(wait_for_file(written)) << desktop_->errors();
  CameraPath moves = path;  // the file is for any scene
  EXPECT_EQ(moves.keys.front().look, review()->looks.at(0).name) << "what it was recorded in is kept";
  moves.keys.front().look.reset();
  EXPECT_EQ(load_path(written), moves);
  key("ctrl+s");
  ASSERT_TRUE(wait_for([&] { return load_review(file).paths.size() == 1; })) << "saved";
  const std::string frames = (folder_ / "frames").string();
  const std::string command = std::string(MAQUETTE_PROGRAM) + " play '" + file + "' --path '" + path.name + "' -o '" +
                              frames + "' --size 48x27 --fps 2 --samples 1 > /dev/null";
  ASSERT_EQ(std::system(command.c_str()), 0);
  double count = 0.0;
  for (const auto& entry : std::filesystem::directory_iterator(frames)) count += entry.path().extension() == ".png";
  EXPECT_NEAR(count, 2.0 * path_duration_s(path), 1.0);
  key("ctrl+q");
  EXPECT_EQ(desktop_->wait_for_exit(), 0) << desktop_->errors();
}

}  // namespace
}  // namespace maquette
