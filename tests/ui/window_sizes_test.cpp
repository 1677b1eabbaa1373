// Windows from 600 x 400 to 3840 x 2160, and text of every size: nothing overlaps, nothing is cut off at a side.
#include <gtest/gtest.h>

#include "tests/support/test_scenes.h"
#include "tests/ui/headless_editor.h"
#include "viewer/measure/measure_run.h"

namespace maquette {
namespace {

using test::HeadlessEditor;

struct Size {
  float width, height;
};
constexpr Size kSizes[] = {{600.0f, 400.0f}, {1280.0f, 720.0f}, {1920.0f, 1080.0f}, {3840.0f, 2160.0f}};
constexpr float kScales[] = {0.6f, 1.0f, 1.25f, 2.0f, 3.0f};

bool inside(const Rect& rect, const Rect& other) {
  constexpr float kRounding = 1.0f;
  return rect.x >= other.x - kRounding && rect.x + rect.width <= other.x + other.width + kRounding;
}

struct Prepared {
  Scene scene = load_scene("builtin:cockpit");
  FrameStats stats;
  std::vector<Message> messages = {{MessageLevel::error, std::string(300, 'x') + " a long error", true},
                                   {MessageLevel::warning, "and a warning", true}};
  Prepared() {
    stats.frame_ms = 1234.5;
    for (int i = 0; i < 12; ++i) stats.passes.push_back({"pass " + std::to_string(i), 1.0 * i});
    for (int i = 0; i < 12; ++i) stats.plan.passes.push_back({"pass", "a reason that takes more than one line"});
  }
  void fill(HeadlessEditor* editor) {
    editor->facts.scene = &scene;
    editor->facts.stats = &stats;
    editor->facts.messages = &messages;
    editor->facts.cameras = {"driver", "passenger", "exterior", "a camera with a long name that has no room"};
    editor->facts.background = {{"visibility", 0.4}, {"octree", 0.2}, {"indirect light", 0.1}};
    for (int i = 0; i < 12; ++i) editor->facts.recent_files.push_back("/home/somebody/of/a/long/path/car.glb");
    editor->facts.device = "a device with a rather long name (and what else a driver says of itself)";
    editor->facts.inspection.sweep_names = sweep_names();
    editor->facts.sun_deg = glm::vec2(40.0f, -130.5f);
    editor->facts.bounds = {glm::vec3(-2.0f), glm::vec3(2.0f)};
    editor->state.reflections = "octree";
    editor->state.selected_material = editor->state.selected_node = 1;
    editor->state.edits.section = glm::vec4(1.0f, 0.0f, 0.0f, 0.0f);
    Look look = editor->state;
    look.name = "a look with a name that is much too long for its row";
    editor->state.looks = {look};
    CameraPath path;
    path.name = "a path with a name that is much too long for its row";
    path.keys.resize(9);
    editor->state.paths = {path};
    editor->state.path_view.key = 0;
  }
};

void expect_in_place(const HeadlessEditor& editor, const Size& size, const std::string& where) {
  const Rect whole{0.0f, 0.0f, size.width, size.height};
  std::vector<std::pair<std::string, Rect>> parts(editor.frame.windows.begin(), editor.frame.windows.end());
  parts.emplace_back("picture", editor.frame.layout.picture);
  for (std::size_t i = 0; i < parts.size(); ++i) {
    const auto& [name, rect] = parts[i];
    EXPECT_TRUE(inside(rect, whole) && rect.y >= 0.0f && rect.y + rect.height <= size.height + 0.5f) << where << name;
    for (std::size_t j = i + 1; j < parts.size(); ++j)
      EXPECT_FALSE(overlap(rect, parts[j].second)) << where << name << " over " << parts[j].first;
  }
}

/// Controls stay within their part, and none lies over another one.
void expect_controls_apart(const HeadlessEditor& editor, const std::string& where) {
  const auto& stops = editor.frame.stops;
  for (std::size_t i = 0; i < stops.size(); ++i) {
    const auto part = editor.frame.windows.find(stops[i].part);
    if (part == editor.frame.windows.end()) continue;
    std::string name;
    for (const auto& [item, rect] : editor.frame.items)
      if (rect.x == stops[i].rect.x && rect.y == stops[i].rect.y) name = item;
    EXPECT_TRUE(inside(stops[i].rect, part->second)) << where << name << " in " << stops[i].part;
    for (std::size_t j = i + 1; j < stops.size(); ++j) {
      if (stops[j].window != stops[i].window) continue;
      // A line of a list takes half of the space around it.
      const ImVec2 space = ImGui::GetStyle().ItemSpacing;
      Rect a = stops[i].rect;
      a = {a.x + 0.5f * space.x + 1.0f, a.y + 0.5f * space.y + 1.0f, a.width - space.x - 2.0f,
           a.height - space.y - 2.0f};
      EXPECT_FALSE(overlap(a, stops[j].rect)) << where << name << " at " << a.x << ", " << a.y;
    }
  }
}

TEST(WindowSizes, PanelsLieInsideAndDoNotOverlap) {
  Prepared prepared;
  for (const Size& size : kSizes)
    for (const float wanted : kScales) {
      const float scale = fitting_scale(wanted, size.width, size.height);
      HeadlessEditor editor(size.width, size.height, scale);
      prepared.fill(&editor);
      editor.step(3);
      for (int panel = 0; panel < static_cast<int>(std::size(kPanelNames)); ++panel) {
        open_panel(&editor.state, panel);
        editor.step(4);
        std::ostringstream where;
        where << size.width << " x " << size.height << ", scale " << scale << ", " << kPanelNames[panel] << ": ";
        EXPECT_TRUE(editor.frame.windows.contains(panel < kLeftPanels ? "left" : "right")) << where.str();
        expect_in_place(editor, size, where.str());
        expect_controls_apart(editor, where.str());
      }
    }
}

TEST(WindowSizes, TheMenuAndTheSideButtonsAreAlwaysThere) {
  Prepared prepared;
  for (const Size& size : kSizes)
    for (const float wanted : kScales) {
      HeadlessEditor editor(size.width, size.height, fitting_scale(wanted, size.width, size.height));
      prepared.fill(&editor);
      editor.step(3);
      for (const char* item : {"menu", "toggle/left", "toggle/right", "open", "save"})
        EXPECT_TRUE(editor.frame.items.contains(item)) << item << " at " << size.width << ", scale " << wanted;
      editor.state.start_popup = true;
      editor.step(4);
      const Rect start = editor.frame.items.at("start");
      EXPECT_TRUE(start.x >= 0.0f && start.x + start.width <= size.width) << size.width << ", scale " << wanted;
      EXPECT_TRUE(start.y >= 0.0f && start.y + start.height <= size.height)
          << start.y << " + " << start.height << " at " << size.height << ", scale " << wanted;
    }
}

TEST(WindowSizes, TheSideThatWasOpenedLastIsShown) {
  Prepared prepared;
  HeadlessEditor editor(600.0f, 400.0f);
  prepared.fill(&editor);
  editor.step(3);
  EXPECT_TRUE(editor.frame.layout.left_shown);
  EXPECT_FALSE(editor.frame.layout.right_shown) << "both have no room";
  ASSERT_TRUE(editor.click("toggle/right"));
  EXPECT_TRUE(editor.frame.layout.right_shown);
  EXPECT_FALSE(editor.frame.layout.left_shown);
  ASSERT_TRUE(editor.click("toggle/left"));
  EXPECT_TRUE(editor.frame.layout.left_shown);
}

TEST(WindowSizes, TheScaleFollowsTheWishWhereThereIsRoom) {
  EXPECT_EQ(fitting_scale(1.0f, 1280.0f, 720.0f), 1.0f);
  EXPECT_EQ(fitting_scale(3.0f, 3840.0f, 2160.0f), 3.0f);
  EXPECT_EQ(fitting_scale(0.6f, 600.0f, 400.0f), 0.6f);
  EXPECT_LT(fitting_scale(3.0f, 600.0f, 400.0f), 1.5f);
  EXPECT_GE(fitting_scale(3.0f, 200.0f, 100.0f), 0.8f) << "it stays legible";
}

}  // namespace
}  // namespace maquette
