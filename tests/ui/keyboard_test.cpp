// Panels without a mouse: every tab and every control in it takes the keyboard, with a frame around it.
#include <gtest/gtest.h>
#include <imgui_internal.h>

#include <set>

#include "tests/support/test_scenes.h"
#include "tests/ui/headless_editor.h"
#include "viewer/measure/measure_run.h"

namespace maquette {
namespace {

using test::HeadlessEditor;

/// Middle of what has the keyboard, in the window.
ImVec2 focus_middle() {
  const ImGuiContext& context = *ImGui::GetCurrentContext();
  const ImRect& rect = context.NavWindow->NavRectRel[context.NavLayer];
  const ImVec2 at = context.NavWindow->Pos;
  return {at.x + 0.5f * (rect.Min.x + rect.Max.x), at.y + 0.5f * (rect.Min.y + rect.Max.y)};
}

/// Names of the control that has the keyboard.
void note_focused(const HeadlessEditor& editor, std::set<std::string>* reached) {
  const auto& stops = editor.frame.stops;
  const auto at = std::ranges::find(stops, ImGui::GetCurrentContext()->NavId, &KeyboardStop::item);
  if (at == stops.end()) return;
  for (const auto& [name, rect] : editor.frame.items)
    if (rect.x == at->rect.x && rect.y == at->rect.y) reached->insert(name);
}

/// Walks through a panel from its tab.
std::set<std::string> walk(HeadlessEditor* editor) {
  constexpr int kMost = 1500;
  const auto focus = [] { return ImGui::GetCurrentContext()->NavId; };
  std::set<std::string> reached;
  const ImGuiID begin = focus();
  for (int i = 0; i < kMost; ++i) {
    editor->state.keyboard_step = 1;
    editor->step(2);
    if (focus() == begin) break;
    note_focused(*editor, &reached);
  }
  return reached;
}

struct KeyboardState {
  Scene scene = load_scene("builtin:cockpit");
  FrameStats stats;
  std::vector<std::string> cameras = {"driver", "passenger"};
  void fill(HeadlessEditor* editor) {
    editor->facts.scene = &scene;
    editor->facts.stats = &stats;
    editor->facts.cameras = cameras;
    editor->facts.can_undo = editor->facts.can_redo = true;
    editor->facts.meter.can_apply = true;
    editor->facts.inspection.sweep_names = sweep_names();
    editor->state.reflections = "octree";
    Look look = editor->state;
    look.name = "A";
    editor->state.looks = {look};
    CameraPath path;
    path.name = "way";
    path.keys.resize(2);
    path.keys[0].name = "a";
    path.keys[1].name = "b";
    path.keys[0].duration_s = 1.0;
    editor->state.paths = {path};
    editor->state.path_view.key = 0;
    editor->state.selected_material = 0;
    editor->state.selected_node = 1;
    editor->state.edits.materials[scene.materials[0].name] = "builtin:glass";
    editor->state.edits.section = glm::vec4(1.0f, 0.0f, 0.0f, 0.0f);
    editor->state.edits.reflectors = {"/windshield"};
  }
};

TEST(Keyboard, EveryTabTakesIt) {
  KeyboardState prepared;
  HeadlessEditor editor(1280.0f, 720.0f);
  prepared.fill(&editor);
  editor.step(3);
  EXPECT_FALSE(editor.frame.navigating);
  EXPECT_EQ(editor.frame.keyboard_part, "picture");
  for (int panel = 0; panel < static_cast<int>(std::size(kPanelNames)); ++panel) {
    open_panel(&editor.state, panel);
    editor.step(4);
    EXPECT_TRUE(editor.frame.navigating) << kPanelNames[panel];
    EXPECT_EQ(editor.frame.keyboard_part, panel < kLeftPanels ? "left" : "right") << kPanelNames[panel];
    const ImVec2 at = focus_middle();
    EXPECT_TRUE(editor.frame.items.at(std::string("tab/") + kPanelNames[panel]).contains(at.x, at.y))
        << kPanelNames[panel];
  }
  editor.state.keyboard_goes_to = "toolbar";
  editor.step(2);
  EXPECT_EQ(editor.frame.keyboard_part, "toolbar");
  editor.press(ImGuiKey_Escape);
  EXPECT_FALSE(editor.frame.navigating) << "Escape gives it back to the picture";
}

TEST(Keyboard, EveryControlIsReached) {
  // These only show something.
  const std::set<std::string> kShown = {"sun", "frame/history", "inspection/legend", "inspection/plot"};
  KeyboardState prepared;
  for (int panel = 0; panel < static_cast<int>(std::size(kPanelNames)); ++panel) {
    HeadlessEditor editor(1280.0f, 720.0f);
    prepared.fill(&editor);
    if (panel == 1) prepared.scene.nodes.resize(std::min<std::size_t>(prepared.scene.nodes.size(), 400));
    editor.step(3);
    open_panel(&editor.state, panel);
    editor.step(4);
    const Rect side = panel < kLeftPanels ? editor.frame.layout.left : editor.frame.layout.right;
    std::set<std::string> wanted;
    for (const auto& [name, rect] : editor.frame.items)
      if (overlap(rect, side) && !name.starts_with("tab/") && !kShown.contains(name)) wanted.insert(name);
    const std::set<std::string> reached = walk(&editor);
    // The first of a list is moved no further up, and the last one no further down.
    for (const char* name : {"look/up/A", "look/down/A", "path/up/way", "path/down/way", "key/up/a", "key/down/b"})
      wanted.erase(name);
    for (const std::string& name : wanted) EXPECT_TRUE(reached.contains(name)) << kPanelNames[panel] << ": " << name;
  }
}

TEST(Keyboard, SpaceAndArrowsChangeAValue) {
  KeyboardState prepared;
  HeadlessEditor editor(1280.0f, 720.0f);
  prepared.fill(&editor);
  open_panel(&editor.state, 4);
  editor.step(4);
  for (int i = 0; i < 40; ++i) {
    editor.press(ImGuiKey_DownArrow);
    const ImVec2 at = focus_middle();
    if (editor.frame.items.at("rotation").contains(at.x, at.y)) break;
  }
  editor.press(ImGuiKey_Space);
  for (int i = 0; i < 3; ++i) editor.press(ImGuiKey_RightArrow);
  EXPECT_GT(editor.state.edits.env_rotation_deg, 1.0f);
  const float turned = editor.state.edits.env_rotation_deg;
  editor.press(ImGuiKey_Space);
  editor.press(ImGuiKey_RightArrow);
  EXPECT_EQ(editor.state.edits.env_rotation_deg, turned) << "the slider was left";
}

/// Tabs to a control of a panel.
void go_to(HeadlessEditor* editor, int panel, const std::string& name) {
  open_panel(&editor->state, panel);
  editor->step(4);
  for (int i = 0; i < 200; ++i) {
    editor->state.keyboard_step = 1;
    editor->step(2);
    std::set<std::string> reached;
    note_focused(*editor, &reached);
    if (reached.contains(name)) return;
  }
  ADD_FAILURE() << name << " was not reached";
}

TEST(Keyboard, EnterPressesAsSpaceDoes) {
  for (const ImGuiKey key : {ImGuiKey_Space, ImGuiKey_Enter}) {
    KeyboardState prepared;
    HeadlessEditor editor(1280.0f, 720.0f);
    prepared.fill(&editor);
    editor.step(3);
    const auto pressed = [&](const bool EditorActions::*action) {
      ImGui::GetIO().KeysDown[key] = true;
      editor.step();
      const bool done = editor.actions.*action;
      ImGui::GetIO().KeysDown[key] = false;
      editor.step(2);
      return done;
    };
    const int review = 3, inspect = 8;
    go_to(&editor, review, "look/keep");
    EXPECT_TRUE(pressed(&EditorActions::keep_look)) << key;
    go_to(&editor, inspect, "inspection/both eyes");
    editor.press(key);
    EXPECT_TRUE(editor.state.inspection.both_eyes) << "a box " << key;
    go_to(&editor, inspect, "inspection/Trends");
    ASSERT_TRUE(editor.frame.items.contains("inspection/run"));
    editor.press(key);
    EXPECT_FALSE(editor.frame.items.contains("inspection/run")) << "a section closes " << key;
    go_to(&editor, inspect, "inspection/light");
    editor.press(key);
    editor.press(ImGuiKey_DownArrow);
    editor.press(key);
    EXPECT_EQ(editor.state.inspection.light, InspectionSetup::Light::given) << "a line of a list " << key;
    editor.state.keyboard_goes_to = "toolbar";
    editor.step(3);
    editor.press(key);
    EXPECT_TRUE(editor.frame.items.contains("menu/Camera")) << "the menu " << key;
  }
}

TEST(Keyboard, DialogsStayOpenUntilTheyAreLeft) {
  KeyboardState prepared;
  HeadlessEditor editor(1280.0f, 720.0f);
  prepared.fill(&editor);
  editor.state.start_popup = true;  // in the very first frame, as in a window without a file
  editor.step(6);
  EXPECT_TRUE(editor.frame.items.contains("start/builtin:sphere"));
  editor.press(ImGuiKey_Escape);
  EXPECT_FALSE(editor.frame.items.contains("start/builtin:sphere"));
  editor.state.open_path_popup = true;
  editor.step(5);
  ASSERT_TRUE(editor.frame.items.contains("dialog/path"));
  const std::vector<Message> messages = {{MessageLevel::error, "a message comes", true}};
  editor.facts.messages = &messages;
  editor.step(5);
  EXPECT_TRUE(editor.frame.windows.contains("strip"));
  EXPECT_TRUE(editor.frame.items.contains("dialog/path")) << "a message does not close it";
}

TEST(Keyboard, EnterPressesInDialogs) {
  KeyboardState prepared;
  HeadlessEditor editor(1280.0f, 720.0f);
  prepared.fill(&editor);
  editor.step(3);
  editor.state.start_popup = true;
  editor.step(4);
  ASSERT_TRUE(editor.frame.items.contains("start/builtin:sphere"));
  for (int i = 0; i < 20; ++i) {
    editor.press(ImGuiKey_DownArrow);
    std::set<std::string> reached;
    note_focused(editor, &reached);
    if (reached.contains("start/another")) break;
  }
  editor.press(ImGuiKey_Enter);
  editor.step(4);
  ASSERT_TRUE(editor.frame.items.contains("dialog/Open")) << "the button opened the next dialog";
  EXPECT_TRUE(editor.frame.typing) << "its field has the keyboard";
  ImGui::GetIO().AddInputCharactersUTF8("builtin:plate");
  editor.step(2);
  editor.state.keyboard_step = 1;
  editor.step(3);
  ImGui::GetIO().KeysDown[ImGuiKey_Enter] = true;
  editor.step();
  EXPECT_EQ(editor.actions.open_path, "builtin:plate");
  ImGui::GetIO().KeysDown[ImGuiKey_Enter] = false;
  editor.step(3);
  EXPECT_FALSE(editor.frame.items.contains("dialog/Open"));
}

TEST(Keyboard, ADialogsFieldHasItAtOnce) {
  for (bool EditorState::*dialog : {&EditorState::open_path_popup, &EditorState::save_path_popup}) {
    KeyboardState prepared;
    HeadlessEditor editor(1280.0f, 720.0f);
    prepared.fill(&editor);
    editor.step(3);
    ASSERT_TRUE(editor.click("tab/Scene")) << "the mouse was used last";
    editor.state.*dialog = true;
    editor.step(6);
    EXPECT_TRUE(editor.frame.typing);
    ImGui::GetIO().AddInputCharactersUTF8("a.glb");
    editor.step(2);
    EXPECT_STREQ(editor.state.path.data(), "a.glb");
  }
}

TEST(Keyboard, EnterTypesANumber) {
  KeyboardState prepared;
  HeadlessEditor editor(1280.0f, 720.0f);
  prepared.fill(&editor);
  editor.step(3);
  editor.state.inspection.background_given = true;
  for (const char* name :
       {"inspection/threshold", "inspection/background", "inspection/eye box", "inspection/columns"}) {
    go_to(&editor, 8, name);
    editor.press(ImGuiKey_Enter);
    EXPECT_TRUE(editor.frame.typing) << name;
    ImGui::GetIO().AddInputCharactersUTF8("7");
    editor.step(2);
    editor.press(ImGuiKey_Enter);
    EXPECT_FALSE(editor.frame.typing) << name;
  }
  EXPECT_EQ(editor.state.inspection.threshold_cdm2, 7.0f);
  EXPECT_EQ(editor.state.inspection.background_cdm2, 7.0f);
  EXPECT_EQ(editor.state.inspection.eye_box_mm[0], 7.0f);
  EXPECT_EQ(editor.state.inspection.grid[0], 7);
}

TEST(Keyboard, TheMenuHoldsEveryCommand) {
  KeyboardState prepared;
  HeadlessEditor editor(1280.0f, 720.0f);
  prepared.fill(&editor);
  editor.step(3);
  for (std::size_t g = 0; g < shortcut_groups().size(); ++g) {
    const ShortcutGroup& group = shortcut_groups()[g];
    for (const Shortcut& shortcut : group.shortcuts) {
      if (shortcut.command == Command::none || shortcut.command == Command::menu) continue;
      editor.state.menu_popup = true;
      editor.state.keyboard_goes_to = "toolbar";
      editor.step(4);
      ASSERT_TRUE(editor.frame.items.contains("menu/" + group.title)) << group.title;
      for (std::size_t i = 0; i < g; ++i) editor.press(ImGuiKey_DownArrow);
      editor.press(ImGuiKey_RightArrow);
      const bool list = shortcut.command == Command::camera || shortcut.command == Command::panel;
      if (!list) {
        ASSERT_TRUE(editor.frame.items.contains("menu/" + shortcut.what)) << shortcut.what;
        ASSERT_TRUE(editor.click("menu/" + shortcut.what));
        ASSERT_EQ(editor.actions.commands.size(), 1u) << shortcut.what;
        EXPECT_EQ(editor.actions.commands[0], shortcut.command) << shortcut.what;
      }
      for (int i = 0; i < 3; ++i) editor.press(ImGuiKey_Escape);
    }
  }
}

}  // namespace
}  // namespace maquette
