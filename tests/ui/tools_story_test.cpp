// Single tools in the real window, by mouse and keys: what the three users' stories do not come to.
#include <gtest/gtest.h>

#include <algorithm>

#include "review/json_reader.h"
#include "tests/ui/story_fixture.h"

namespace maquette {
namespace {

class ToolsStory : public Story {
 protected:
  ToolsStory() { height_ = 760; }  // the fields of a key are in sight
  /// Opens a tab, and waits until one of its controls is there.
  void open_tab(Controls* at, const std::string& tab, int* number_of, int number, const std::string& control) {
    const ScreenPicture before = desktop_->grab();
    desktop_->click(at->item("tab/" + tab));
    *number_of = number;
    ASSERT_TRUE(wait_for_change(before, at->item(control), 1.0)) << tab;
  }
  void open_plate(const std::vector<std::string>& more = {}) {
    std::vector<std::string> arguments = {"builtin:plate", "--set", "shading.visibility=none", "--set",
                                          "shading.indirect=none"};
    arguments.insert(arguments.end(), more.begin(), more.end());
    begin(arguments);
  }
  Scene scene_ = load_scene("builtin:plate");
};

TEST_F(ToolsStory, AMaterialIsResetAndPartsAreFoundAndHidden) {
  Controls at = controls(scene_);
  const Rect middle = middle_of(at.picture());
  open_plate();
  ASSERT_TRUE(wait_for_picture(middle)) << desktop_->errors();
  press(&at, "material/Paint");
  const std::string white = "builtin:" + builtin_brdfs()[1].name;
  press(&at, "library/" + white);
  ASSERT_TRUE(wait_for_review([&](const Review& r) { return r.look.edits.materials.contains("Paint"); }));
  press(&at, "material/Metal");
  press(&at, "library/" + white);
  ASSERT_TRUE(wait_for_review([&](const Review& r) { return r.look.edits.materials.contains("Metal"); }));
  desktop_->click(at.item("restore"));
  ASSERT_TRUE(wait_for_review([&](const Review& r) { return !r.look.edits.materials.contains("Metal"); }));
  EXPECT_TRUE(review()->look.edits.materials.contains("Paint")) << "the other one keeps what it has";

  const ScreenPicture all = settled();
  open_tab(&at, "Scene", &at.state().left_tab, 1, "section");
  type_into(&at, "Search nodes", "plast");
  std::snprintf(at.state().node_search.data(), at.state().node_search.size(), "plast");
  desktop_->click(at.item("visible/statue_plastic"));
  ASSERT_TRUE(wait_for_review([](const Review& r) { return r.look.edits.hidden_nodes.contains("/statue_plastic"); }))
      << desktop_->errors();
  EXPECT_EQ(review()->look.edits.hidden_nodes.size(), 1u);
  EXPECT_TRUE(wait_for_change(all, middle)) << "it is no longer seen";
}

TEST_F(ToolsStory, AKeyHasAnEaseAndTimesAreCopied) {
  Controls at = controls(scene_);
  open_plate();
  ASSERT_TRUE(wait_for_picture(middle_of(at.picture()))) << desktop_->errors();
  FrameStats stats;
  at.facts().stats = &stats;
  at.facts().frame_history_ms = {1.0f, 2.0f};
  open_tab(&at, "Frame", &at.state().right_tab, 2, "frame/copy");
  desktop_->click(at.item("frame/copy"));
  std::string table;
  EXPECT_TRUE(wait_for([&] {
    table = desktop_->clipboard();
    return table.starts_with("frame_ms,");
  })) << "the times, as CSV, are in the clipboard: "
      << table;
  EXPECT_GT(std::count(table.begin(), table.end(), '\n'), 2);
  at.facts().stats = nullptr;

  open_tab(&at, "Review", &at.state().left_tab, 3, "path/turntable");
  press(&at, "section/Looks");
  desktop_->click(at.item("path/turntable"));
  ASSERT_TRUE(wait_for_review([](const Review& r) { return r.paths.size() == 1; })) << desktop_->errors();
  at.state().paths = review()->paths;
  desktop_->click(at.item("key/1"));
  at.state().path_view.key = 0;
  choose(&at, "key/ease", static_cast<int>(Ease::smooth));
  EXPECT_TRUE(wait_for_review([](const Review& r) { return r.paths[0].keys[0].ease == Ease::smooth; }))
      << desktop_->errors();
  EXPECT_EQ(review()->paths[0].keys[1].ease, Ease::linear) << "each key has its own";
}

TEST_F(ToolsStory, FullScreenAndBack) {
  constexpr int kSmallWidth = 600, kSmallHeight = 400;
  desktop_->start({"view", "builtin:plate", "--size", "600x400", "--set", "shading.visibility=none", "--set",
                   "shading.indirect=none"});
  const Rect beyond{kSmallWidth + 10.0f, kSmallHeight + 10.0f, static_cast<float>(width_ - kSmallWidth) - 20.0f,
                    static_cast<float>(height_ - kSmallHeight) - 60.0f};
  ASSERT_TRUE(wait_for_picture({320.0f, 50.0f, 270.0f, 300.0f})) << desktop_->errors();
  const ScreenPicture small = desktop_->grab();
  EXPECT_LT(test::contrast(small, beyond), 1.0);
  desktop_->move(450.0f, 200.0f);
  key("F11");
  EXPECT_TRUE(wait_for_change(small, beyond, 5.0)) << "it covers the screen";
  key("F11");
  EXPECT_TRUE(desktop_->wait_until([&](const ScreenPicture& p) { return difference(small, p, beyond) < 1.0; }))
      << "and gives it back";
  EXPECT_TRUE(desktop_->running());
}

TEST_F(ToolsStory, LayersAndLuxOnTheGlass) {
  const Scene scene = load_scene("builtin:cockpit");
  Controls at = controls(scene);
  at.facts().inspection.has_r_point = true;
  const Rect middle = middle_of(at.picture());
  begin({"builtin:cockpit", "--set", "shading.visibility=none", "--set", "shading.indirect=none", "--reflections",
         "raytraced"});
  ASSERT_TRUE(wait_for_picture(middle)) << desktop_->errors();
  key("bracketright");  // one exposure for all layers
  ASSERT_TRUE(wait_for_review([](const Review& r) { return !r.look.auto_exposure; }));
  open_tab(&at, "Inspect", &at.state().right_tab, 4, "inspection/v1");
  press(&at, "inspection/Eye");
  const ScreenPicture all = settled();
  choose(&at, "inspection/layer", 2);
  EXPECT_TRUE(
      wait_for_review([](const Review& r) { return r.look.settings.get_string("reflections.layer") == "reflected"; }));
  EXPECT_TRUE(wait_for_change(all, middle, 5.0)) << "what the pane mirrors is all that is left in it";
  choose(&at, "inspection/layer", 0);
  EXPECT_TRUE(
      wait_for_review([](const Review& r) { return r.look.settings.get_string("reflections.layer") == "all"; }));
  for (const char* part : {"inspection/Luminance", "inspection/Regions", "inspection/Trends"}) press(&at, part);
  choose(&at, "inspection/light", 1);
  const Rect lux = at.item("inspection/lux");
  desktop_->move(lux.x + 0.3f * lux.width, lux.y + 0.5f * lux.height);
  desktop_->input({"keydown", "ctrl", "click", "1", "keyup", "ctrl", "type", "--delay", "1", "50000"});
  key("Return");
  EXPECT_TRUE(wait_for_review([](const Review& r) {
    return r.inspection.light == InspectionSetup::Light::given && r.inspection.lux_on_glass == 50000.0f;
  })) << desktop_->errors();
  const std::string file = (folder_ / "lux.csv").string();
  type_into(&at, "inspection/path", file);
  key("Return");
  press(&at, "inspection/export");
  ASSERT_TRUE(wait_for_file(file)) << desktop_->errors();
  const std::string table = read_text_file(file);
  EXPECT_NE(table.find("scaled to 50000 lx"), std::string::npos) << table;
}

/// The smallest window that is to be usable.
class SmallStory : public ToolsStory {
 protected:
  SmallStory() {
    pictures_.clear();
    width_ = 600;
    height_ = 400;
  }
};

TEST_F(SmallStory, DistanceSectionCompareAndTimeline) {
  Controls at = controls(scene_);
  const Rect picture = at.picture(), middle = middle_of(picture);
  open_plate();
  ASSERT_TRUE(wait_for_picture(middle)) << desktop_->errors();
  const ScreenPicture plain = settled();
  const float y = picture.y + 0.43f * picture.height;
  desktop_->move(picture.x + 0.2f * picture.width, y);
  key("m");
  for (const float x : {0.2f, 0.6f}) desktop_->click({picture.x + x * picture.width, y, 1.0f, 1.0f});
  const Rect line{picture.x + 0.25f * picture.width, y - 4.0f, 0.3f * picture.width, 8.0f};
  EXPECT_TRUE(wait_for_change(plain, line, 10.0)) << "a line between both ends";
  key("Escape");
  EXPECT_TRUE(desktop_->wait_until([&](const ScreenPicture& p) { return difference(plain, p, line) < 5.0; }));

  key("l");
  ASSERT_TRUE(wait_for_review([](const Review& r) { return r.looks.size() == 1; }));
  open_tab(&at, "Scene", &at.state().left_tab, 1, "section");
  choose(&at, "section", 1);
  EXPECT_TRUE(wait_for_review([](const Review& r) { return r.look.edits.section.x == 1.0f; })) << desktop_->errors();
  const Rect right{picture.x + 0.6f * picture.width, middle.y, 0.35f * picture.width, middle.height};
  EXPECT_TRUE(wait_for_change(plain, right, 5.0)) << "what lies beyond is cut away";
  key("ctrl+z");
  EXPECT_TRUE(wait_for_review([](const Review& r) { return r.look.edits.section == glm::vec4(0.0f); }));

  // Two looks that are the same: a difference is dark, without dots along edges.
  key("l");
  ASSERT_TRUE(wait_for_review([](const Review& r) { return r.looks.size() == 2; }));
  desktop_->move(picture.x + 20.0f, picture.y + 20.0f);
  key("c");
  const Rect top{picture.x + 10.0f, picture.y + 40.0f, picture.width - 20.0f, 30.0f};
  key("b");
  EXPECT_TRUE(wait_for_change(plain, top, 20.0)) << "side by side leaves the top free";
  key("b");
  const Rect edges{picture.x + 4.0f, picture.y + 0.33f * picture.height, picture.width - 8.0f, 0.4f * picture.height};
  EXPECT_TRUE(desktop_->wait_until([&](const ScreenPicture& p) {
    return difference(plain, p, edges) > 20.0 && test::contrast(p, edges) < 5.0;
  })) << "equal looks differ nowhere, contrast "
      << test::contrast(desktop_->grab(), edges);
  key("c");

  open_tab(&at, "Review", &at.state().left_tab, 3, "look/keep");
  press(&at, "section/Looks");
  desktop_->click(at.item("path/turntable"));
  ASSERT_TRUE(wait_for_review([](const Review& r) { return r.paths.size() == 1; })) << desktop_->errors();
  const std::vector<double> times = key_times_s(review()->paths[0]);
  at.state().paths = review()->paths;
  const Rect second = at.item("timeline/2");
  const float at_y = second.y + 0.5f * second.height, x = second.x + 0.5f * second.width;
  drag(x, at_y, x + 12.0f, at_y);
  EXPECT_TRUE(wait_for_review([&](const Review& r) { return key_times_s(r.paths[0])[1] > times[1] + 0.1; }))
      << "a key is dragged";
  EXPECT_NEAR(key_times_s(review()->paths[0])[2], times[2], 1e-6) << "the others stay";
}

}  // namespace
}  // namespace maquette
