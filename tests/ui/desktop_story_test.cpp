// What desktops do with the window: files that are dropped on it, and dense screens.
#include <gtest/gtest.h>

#include <fstream>

#include "review/camera_path.h"
#include "scenes/files.h"
#include "scenes/image_io.h"
#include "tests/ui/story_fixture.h"
#include "tests/ui/x11.h"
#include "viewer/outputs.h"

namespace maquette {
namespace {

class DropStory : public Story {
 protected:
  bool drop(const std::string& file) {
    const Rect at = middle_;
    desktop_->move(at.x + 0.5f * at.width, at.y + 0.5f * at.height);
    return test::drop_files(desktop_->display(), static_cast<int>(at.x + 0.5f * at.width),
                            static_cast<int>(at.y + 0.5f * at.height), {file});
  }
  std::string file(const std::string& name) const { return (folder_ / name).string(); }
  /// A MERL table of one colour at all angles.
  std::string lambertian(const std::string& name) const {
    constexpr int kSides[] = {90, 90, 180};
    const std::vector<double> values(3u * 90u * 90u * 180u, 300.0);
    std::ofstream stream(file(name), std::ios::binary);
    stream.write(reinterpret_cast<const char*>(kSides), sizeof kSides);
    stream.write(reinterpret_cast<const char*>(values.data()),
                 static_cast<std::streamsize>(values.size() * sizeof(double)));
    return file(name);
  }
  /// Whether a message comes below the picture.
  bool wait_for_message(Controls* at, const ScreenPicture& before) {
    const Rect picture = at->picture();
    const Rect strip{picture.x, picture.y + picture.height - 50.0f, picture.width, 40.0f};
    return wait_for_change(before, strip, 2.0);
  }
  Rect middle_{};
};

TEST_F(DropStory, EachKindOfFileGoesWhereItBelongs) {
  const Scene scene = load_scene("builtin:sphere");
  Controls at = controls(scene);
  middle_ = middle_of(at.picture());
  begin({"builtin:sphere", "--mode", "splitsum"});
  ASSERT_TRUE(wait_for_picture(middle_)) << desktop_->errors();

  Image sky(32, 16, 3, 1.0f);
  for (std::size_t i = 0; i < sky.data.size(); i += 3) sky.data[i] = 4.0f;
  save_exr(file("red sky.exr"), sky);
  ASSERT_TRUE(drop(file("red sky.exr"))) << desktop_->errors();
  ASSERT_TRUE(wait_for_review([&](const Review& r) { return r.look.edits.environment == file("red sky.exr"); }))
      << desktop_->errors();

  const std::string table = lambertian("grey.binary");
  ASSERT_TRUE(drop(table));
  ASSERT_TRUE(wait_for_review([&](const Review& r) {
    const auto given = r.look.edits.materials.find("Sphere");
    return given != r.look.edits.materials.end() && given->second == table;
  })) << desktop_->errors();

  CameraPath path;
  path.name = "around";
  path.keys.resize(2);
  path.keys[0].camera = path.keys[1].camera = review()->look.camera;
  save_path(file("around.json"), path);
  const ScreenPicture before = settled();
  ASSERT_TRUE(drop(file("around.json")));
  ASSERT_TRUE(wait_for_review([](const Review& r) { return r.paths.size() == 1 && r.paths[0].name == "around"; }));
  EXPECT_TRUE(wait_for_message(&at, before)) << "it says where the path is";

  Review other;
  other.scene = "builtin:plate";
  other.look = review()->look;
  other.look.edits.materials = {{"Paint", table}};
  const std::string review_file = file("other.maquette.json");
  save_review(review_file, other);
  ASSERT_TRUE(drop(review_file));
  ASSERT_TRUE(wait_for([&] { return std::filesystem::exists(journal_file(review_file)); })) << desktop_->errors();
  EXPECT_TRUE(desktop_->running()) << desktop_->errors();
}

TEST_F(DropStory, WhatIsNothingIsSaidAndChangesNothing) {
  const Scene scene = load_scene("builtin:sphere");
  Controls at = controls(scene);
  middle_ = middle_of(at.picture());
  begin({"builtin:sphere", "--mode", "splitsum"});
  ASSERT_TRUE(wait_for_picture(middle_)) << desktop_->errors();
  const ScreenPicture before = settled();
  const Review was = *review();
  for (const char* name : {"a.txt", "a.glb", "a.hdr", "a.exr", "a.binary", "a.btf", "a.json", "a.maquette.json"}) {
    write_text(file(name), "this is nothing of the kind\n");
    ASSERT_TRUE(drop(file(name))) << name;
  }
  ASSERT_TRUE(drop(file("not there.glb")));
  EXPECT_TRUE(wait_for_message(&at, before)) << desktop_->errors();
  // Undo has nothing to take back, and the next change is the first.
  key("bracketright");
  ASSERT_TRUE(wait_for_review([&](const Review& r) { return r.look.exposure_ev != was.look.exposure_ev; }));
  Review now = *review();
  EXPECT_EQ(now.look.edits, was.look.edits);
  EXPECT_TRUE(now.paths.empty());
  EXPECT_EQ(now.scene, was.scene);
  EXPECT_TRUE(desktop_->running()) << desktop_->errors();
}

/// A screen of twice the usual density: the window grows with it where nobody asked for a size, and only once.
TEST_F(DropStory, AWindowKeepsItsSizeOnADenseScreen) {
  const auto opened = [&](const std::vector<std::string>& more) {
    std::vector<std::string> words = {"view", "builtin:sphere", "--mode", "splitsum", "--samples", "2"};
    words.insert(words.end(), more.begin(), more.end());
    desktop_->start(words);
    test::WindowSize size;
    wait_for([&] { return (size = test::window_size(desktop_->display())).width > 0; });
    desktop_->input({"mousemove", "300", "200"});
    const Rect all{0.0f, 0.0f, static_cast<float>(size.width), static_cast<float>(size.height)};
    EXPECT_TRUE(wait_for_picture(all)) << desktop_->errors();
    size = test::window_size(desktop_->display());
    key("ctrl+q");
    EXPECT_EQ(desktop_->wait_for_exit(), 0) << desktop_->errors();
    return size;
  };
  test::set_dpi(desktop_->display(), 192);
  const test::WindowSize screen{width_, height_};
  EXPECT_EQ(opened({"--size", "500x320"}), (test::WindowSize{500, 320})) << "pixels are pixels";
  EXPECT_EQ(opened({}), (test::WindowSize{500, 320})) << "as it was left";
  EXPECT_EQ(opened({}), (test::WindowSize{500, 320})) << "again";
  desktop_.reset();
  open_desktop();
  test::set_dpi(desktop_->display(), 192);
  EXPECT_EQ(opened({}), screen) << "2560 x 1440 would not fit";
  EXPECT_EQ(opened({}), screen);
}

}  // namespace
}  // namespace maquette
