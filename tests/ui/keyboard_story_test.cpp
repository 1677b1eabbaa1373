// A review in the real window by keys alone: a paint, the light, two looks, the file.
#include <gtest/gtest.h>

#include "tests/ui/story_fixture.h"

namespace maquette {
namespace {

class KeyboardStory : public Story {
 protected:
  void keys(const std::string& name, int count) {
    for (int i = 0; i < count; ++i) key(name);
  }
  /// The first command of the third group of the menu.
  bool keep_look_by_menu(std::size_t count) {
    key("F10");
    keys("Down", 2);
    key("Right");
    keep_screen("keyboard-menu");
    key("Return");
    return wait_for_review([&](const Review& r) { return r.looks.size() == count; });
  }
};

TEST_F(KeyboardStory, ReviewsWithoutAMouse) {
  const Scene scene = load_scene("builtin:sphere");
  Controls at = controls(scene);
  const Rect picture = at.picture();
  const std::string material = "material/" + scene.materials.front().name;
  const std::string source = "builtin:" + builtin_brdfs()[4].name;
  begin({"builtin:sphere"});
  ASSERT_TRUE(wait_for_picture(middle_of(picture))) << desktop_->errors();

  key("ctrl+1");
  keys("Tab", at.steps("tab/Materials", material));
  key("space");
  at.state().selected_material = 0;
  keys("Tab", at.steps(material, "library/" + source));
  keep_screen("keyboard-focus");
  key("space");
  ASSERT_TRUE(wait_for_review([&](const Review& r) {
    return !r.look.edits.materials.empty() && r.look.edits.materials.begin()->second == source;
  })) << desktop_->errors();
  ASSERT_TRUE(keep_look_by_menu(1)) << desktop_->errors();

  key("ctrl+5");
  keys("Tab", at.steps("tab/Look", "rotation"));
  key("space");
  keys("Right", 4);  // a hundredth of the range each
  key("space");
  ASSERT_TRUE(wait_for_review([](const Review& r) { return r.look.edits.env_rotation_deg > 14.0f; }))
      << desktop_->errors();
  const float turned = review()->look.edits.env_rotation_deg;
  ASSERT_TRUE(keep_look_by_menu(2)) << desktop_->errors();
  const std::string second = review()->look.name;

  keys("Escape", 3);  // back to the picture, whose keys are others
  key("Page_Up");
  ASSERT_TRUE(wait_for_review([&](const Review& r) { return r.look.name != second; })) << desktop_->errors();
  EXPECT_EQ(review()->look.edits.env_rotation_deg, 0.0f);
  key("Page_Down");
  ASSERT_TRUE(wait_for_review([&](const Review& r) { return r.look.edits.env_rotation_deg == turned; }));

  const std::string file = (folder_ / "keys.maquette.json").string();
  key("ctrl+s");
  desktop_->input({"type", "--delay", "1", file});
  key("Return");
  ASSERT_TRUE(wait_for_file(file)) << desktop_->errors();
  EXPECT_EQ(load_review(file).looks.size(), 2u);
  key("ctrl+q");
  EXPECT_EQ(desktop_->wait_for_exit(), 0) << desktop_->errors();
}

}  // namespace
}  // namespace maquette
