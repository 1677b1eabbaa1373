#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <set>

#include "render/technique/registry.h"
#include "scenes/brdf.h"
#include "test_paths.h"
#include "tests/ui/headless_editor.h"
#include "tests/ui/small_scene.h"
#include "ui/bake_state.h"

namespace maquette {
namespace {

using test::HeadlessEditor;
using test::small_scene;

FrameStats busy_stats() {
  FrameStats stats;
  stats.frame_ms = 123.4;
  for (int i = 0; i < 12; ++i) stats.passes.push_back({"pass " + std::to_string(i), 1.0 * i});
  for (int i = 0; i < 12; ++i)
    stats.plan.passes.push_back({"pass", "a reason that takes more than one line in a narrow panel, as reasons do"});
  for (int i = 0; i < 12; ++i) stats.plan.left_out.push_back({"what", "and why it was left out of this frame"});
  stats.visible_pixels = 1234567;
  stats.shaded_pixels = 123456;
  return stats;
}

void expect_windows_apart(const HeadlessEditor& editor) {
  auto rects = std::vector<std::pair<std::string, Rect>>(editor.frame.windows.begin(), editor.frame.windows.end());
  rects.emplace_back("picture", editor.frame.layout.picture);
  for (std::size_t i = 0; i < rects.size(); ++i)
    for (std::size_t j = i + 1; j < rects.size(); ++j)
      EXPECT_FALSE(overlap(rects[i].second, rects[j].second)) << rects[i].first << " over " << rects[j].first;
}

TEST(Panels, NothingOverlapsAt1280x720) {
  const Scene scene = small_scene();
  const FrameStats stats = busy_stats();
  const std::vector<Message> messages = {{MessageLevel::error, std::string(400, 'x') + " a long error", true}};
  for (const float scale : {1.0f, 1.25f}) {
    HeadlessEditor editor(1280.0f, 720.0f, scale);
    editor.facts.scene = &scene;
    editor.facts.stats = &stats;
    editor.facts.messages = &messages;
    editor.facts.background = {{"visibility", 0.4}};
    editor.state.reflections = "bezier";
    editor.state.tool = Tool::reflect;
    editor.facts.reflecting = {0};
    for (int tab = 0; tab < 4; ++tab) {
      editor.state.left_tab = editor.state.right_tab = tab;
      editor.step(3);
      EXPECT_EQ(editor.frame.windows.size(), 5u) << "toolbar, status, strip, left, right";
      expect_windows_apart(editor);
    }
  }
}

TEST(Panels, ControlsStayInsideTheirSide) {
  const Scene scene = small_scene();
  const FrameStats stats = busy_stats();
  HeadlessEditor editor(1280.0f, 720.0f);
  editor.facts.scene = &scene;
  editor.facts.stats = &stats;
  editor.facts.cameras = {"driver", "passenger"};
  editor.state.selected_material = 2;
  for (int tab = 0; tab < 4; ++tab) {
    editor.state.left_tab = editor.state.right_tab = tab;
    editor.step(3);
    const Layout& layout = editor.frame.layout;
    for (const auto& [name, rect] : editor.frame.items) {
      const bool left = rect.x < layout.picture.x, right = rect.x >= layout.right.x;
      if (rect.y < layout.picture.y || (!left && !right)) continue;
      const Rect& side = left ? layout.left : layout.right;
      EXPECT_LE(rect.x + rect.width, side.x + side.width) << name;
    }
  }
}

TEST(Panels, SlidersLeaveRoomForWhatStandsBehindThem) {
  const Scene scene = small_scene();
  for (const float width : {600.0f, 1280.0f}) {
    HeadlessEditor editor(width, 720.0f);
    editor.facts.scene = &scene;
    editor.state.left_tab = 1;
    editor.state.selected_node = 1;
    editor.step(4);
    const Rect flip = editor.frame.items.at("section/flip");
    for (const char* name : {"part", "turn"}) {
      const Rect rect = editor.frame.items.at(name);
      EXPECT_LE(rect.x + rect.width, flip.x + flip.width + 0.5f) << name << " at " << width;
    }
  }
}

/// The grab would cover a value that stands on it.
TEST(Panels, EverySliderHasItsValueBesideIt) {
  std::size_t sliders = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::string(MAQUETTE_SOURCE_DIR) + "/ui")) {
    if (entry.path().extension() != ".cpp" || entry.path().filename() == "widgets.cpp") continue;
    std::ifstream stream(entry.path());
    for (std::string line; std::getline(stream, line);) {
      sliders += line.find("slider(\"##") != std::string::npos ? 1 : 0;
      const bool plain = line.find("ImGui::Slider") != std::string::npos && line.find("\"\");") == std::string::npos;
      EXPECT_FALSE(plain) << entry.path().filename() << ": " << line;
    }
  }
  EXPECT_GT(sliders, 5u);
}

TEST(Panels, PartsTakeAModeInTheSceneTree) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 720.0f);
  editor.facts.scene = &scene;
  editor.state.left_tab = 1;
  editor.step(3);
  ASSERT_TRUE(editor.click("node/door_left", 1));
  EXPECT_EQ(editor.frame.items.count("part mode/reference"), 0u) << "it draws whole pictures";
  ASSERT_TRUE(editor.click("part mode/splitsum"));
  EXPECT_EQ(editor.state.edits.part_modes, (std::map<std::string, std::string>{{"/car/door_left", "splitsum"}}));
  ASSERT_TRUE(editor.click("node/car", 1));
  ASSERT_TRUE(editor.click("part mode/sg"));
  EXPECT_EQ(editor.state.edits.part_modes,
            (std::map<std::string, std::string>{{"/car", "sg"}, {"/car/door_left", "splitsum"}}));
  ASSERT_TRUE(editor.click("node/door_left", 1));
  ASSERT_TRUE(editor.click("part mode/as above"));
  EXPECT_EQ(editor.state.edits.part_modes, (std::map<std::string, std::string>{{"/car", "sg"}}));
}

TEST(Panels, KnowNoTechniqueByItsName) {
  const Scene scene = small_scene();
  const FrameStats stats = busy_stats();
  Registry renamed = builtin_registry();
  for (Technique& technique : renamed.techniques) technique.name = "renamed-" + technique.name;
  for (const Technique& technique : builtin_registry().techniques) {
    if (technique.kind == TechniqueKind::shared) continue;
    const auto items = [&](const Registry& registry, const std::string& prefix) {
      HeadlessEditor editor(1280.0f, 720.0f);
      editor.facts.scene = &scene;
      editor.facts.stats = &stats;
      editor.facts.registry = &registry;
      editor.state.mode = prefix + (technique.kind == TechniqueKind::mode ? technique.name : registry.default_mode);
      if (technique.kind == TechniqueKind::reflector) editor.state.reflections = prefix + technique.name;
      std::vector<std::string> seen;
      for (int tab = 0; tab < 4; ++tab) {
        editor.state.left_tab = editor.state.right_tab = tab;
        editor.step(3);
        for (const auto& [name, rect] : editor.frame.items) seen.push_back(name + " " + std::to_string(rect.y));
      }
      editor.state.left_tab = 1;
      EXPECT_TRUE(editor.click("node/car", 1));
      for (const Technique& t : registry.techniques)
        seen.push_back(std::to_string(editor.frame.items.count("part mode/" + t.name)));
      return seen;
    };
    EXPECT_EQ(items(builtin_registry(), ""), items(renamed, "renamed-")) << technique.name;
  }
}

TEST(Panels, ToolbarFitsSideBySide) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 720.0f);
  editor.facts.scene = &scene;
  editor.step(2);
  const char* const kOrder[] = {"toggle/left", "open", "frame", "dent", "undo", "toggle/right"};
  for (std::size_t i = 1; i < std::size(kOrder); ++i) {
    const Rect &a = editor.frame.items.at(kOrder[i - 1]), &b = editor.frame.items.at(kOrder[i]);
    EXPECT_LE(a.x + a.width, b.x) << kOrder[i - 1] << " over " << kOrder[i];
  }
}

TEST(Panels, TwoClicksReplaceAMaterial) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 720.0f);
  editor.facts.scene = &scene;
  ASSERT_TRUE(editor.click("material/leather"));
  EXPECT_EQ(editor.state.selected_material, 1);
  const std::string paint = "builtin:" + builtin_brdfs()[2].name;
  ASSERT_TRUE(editor.click("library/" + paint));
  EXPECT_EQ(editor.state.edits.materials, (std::map<std::string, std::string>{{"leather", paint}}));
  ASSERT_TRUE(editor.click("restore"));
  EXPECT_TRUE(editor.state.edits.materials.empty());
}

TEST(Panels, SearchNarrowsTheMaterials) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 720.0f);
  editor.facts.scene = &scene;
  std::snprintf(editor.state.material_search.data(), editor.state.material_search.size(), "LEATH");
  editor.step(2);
  EXPECT_TRUE(editor.frame.items.contains("material/leather"));
  EXPECT_FALSE(editor.frame.items.contains("material/paint"));
}

TEST(Panels, ANodeHidesAndIsChosen) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 720.0f);
  editor.facts.scene = &scene;
  editor.state.left_tab = 1;
  ASSERT_TRUE(editor.click("visible/door_left"));
  EXPECT_EQ(editor.state.edits.hidden_nodes, std::set<std::string>{"/car/door_left"});
  ASSERT_TRUE(editor.click("node/door_left"));
  EXPECT_EQ(editor.state.selected_node, 1);
  EXPECT_EQ(editor.state.selected_material, 1) << "its material is chosen with it";
}

TEST(Panels, VariantsAndToolsAreClicks) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 900.0f);
  editor.facts.scene = &scene;
  editor.facts.can_undo = true;
  ASSERT_TRUE(editor.click("variant/touring"));
  EXPECT_EQ(editor.state.edits.variant, "touring");
  ASSERT_TRUE(editor.click("dent"));
  EXPECT_EQ(editor.state.tool, Tool::dent);
  ASSERT_TRUE(editor.click("undo"));
  EXPECT_TRUE(editor.actions.undo);
  ASSERT_TRUE(editor.click("toggle/right"));
  EXPECT_FALSE(editor.state.right_open);
  EXPECT_FALSE(editor.frame.layout.right_shown);
}

TEST(Panels, EveryDeclaredSettingOfTheModeHasAControl) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 2000.0f);
  editor.facts.scene = &scene;
  editor.state.mode = "bandwidth";
  editor.state.reflections = "off";
  editor.state.right_tab = 1;
  editor.step(3);
  const auto expect_shown = [&](const std::set<std::string>& techniques) {
    int shown = 0;
    for (const SettingDeclaration& declaration : setting_declarations()) {
      const bool mine = techniques.contains(declaration.name.substr(0, declaration.name.find('.')));
      EXPECT_EQ(editor.frame.items.contains("setting/" + declaration.name), mine) << declaration.name;
      shown += mine ? 1 : 0;
    }
    EXPECT_GE(shown, 4);
  };
  expect_shown({"bandwidth", "shading", "ground", "btf"});
  ASSERT_TRUE(editor.click("reflections"));
  editor.step(2);
  ASSERT_TRUE(editor.click("reflections/raytraced"));
  editor.step(3);
  EXPECT_EQ(editor.state.reflections, "raytraced");
  ASSERT_TRUE(editor.click("pick reflectors"));
  EXPECT_EQ(editor.state.tool, Tool::reflect);
  editor.state.edits.reflectors = {"a node"};
  editor.step(2);
  ASSERT_TRUE(editor.click("scene reflectors"));
  EXPECT_TRUE(editor.state.edits.reflectors.empty());
  editor.state.tool = Tool::camera;
  editor.state.settings.set_from_text("shading.visibility", "traced");
  editor.step(3);
  expect_shown({"bandwidth", "shading", "ground", "btf", "octree", "reflections", "raytraced"});
}

TEST(Panels, AdviceIsCarriedOutByItsButton) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 900.0f);
  editor.facts.scene = &scene;
  std::vector<Message> messages{{MessageLevel::warning, "the lamps outshine the environment", true, "units",
                                 "Intensity 900", [](EditorState* state) { state->edits.env_scale = 900.0f; }}};
  editor.facts.messages = &messages;
  editor.step(2);
  ASSERT_TRUE(editor.click("remedy"));
  EXPECT_EQ(editor.state.edits.env_scale, 900.0f);
  EXPECT_EQ(editor.actions.dismiss_message, 0);
  messages[0].remedy.clear();
  editor.step(2);
  EXPECT_FALSE(editor.frame.items.contains("remedy"));
  EXPECT_TRUE(editor.frame.items.contains("dismiss"));
}

TEST(Panels, EachMessageStaysUntilItIsRead) {
  HeadlessEditor editor(1280.0f, 900.0f);
  std::vector<Message> messages{
      {MessageLevel::warning, "the review is open in another window"},
      {MessageLevel::error, "a material cannot be read"},
      {MessageLevel::warning, "paint looks like chalk", true, "gloss", "Open the library", [](EditorState*) {}}};
  editor.facts.messages = &messages;
  for (const int expected : {1, 0, 2}) {  // advice that came later hides neither
    ASSERT_TRUE(editor.click("dismiss"));
    EXPECT_EQ(editor.actions.dismiss_message, expected);
    EXPECT_FALSE(editor.actions.dismiss_messages);
    messages[static_cast<std::size_t>(expected)].unread = false;
  }
  for (Message& message : messages) message.unread = true;
  ASSERT_TRUE(editor.click("dismiss all"));
  EXPECT_TRUE(editor.actions.dismiss_messages);
}

TEST(Panels, TheErrorTabMeasuresOnlyWhileInSight) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 900.0f);
  editor.facts.scene = &scene;
  editor.step(2);
  EXPECT_FALSE(editor.state.error_view.open);
  ASSERT_TRUE(editor.click("tab/Error"));
  editor.step(2);
  EXPECT_TRUE(editor.state.error_view.open);
  ASSERT_TRUE(editor.click("error/apply"));
  EXPECT_FALSE(editor.actions.apply_budget) << "nothing was measured";
  ASSERT_TRUE(editor.click("error/measure"));
  EXPECT_TRUE(editor.actions.measure_curve);
  ASSERT_TRUE(editor.click("error/wiper"));
  EXPECT_EQ(editor.state.error_view.show, ErrorView::Show::wiper);
  editor.facts.meter.can_apply = true;
  ASSERT_TRUE(editor.click("error/apply"));
  EXPECT_TRUE(editor.actions.apply_budget);
  expect_windows_apart(editor);
  ASSERT_TRUE(editor.click("tab/Look"));
  editor.step(2);
  EXPECT_FALSE(editor.state.error_view.open);
}

TEST(Panels, OneByOneAndHugeWindowsDoNoHarm) {
  const Scene scene = small_scene();
  for (const auto& [width, height] : {std::pair{1.0f, 1.0f}, {7680.0f, 4320.0f}, {300.0f, 200.0f}}) {
    HeadlessEditor editor(width, height);
    editor.facts.scene = &scene;
    editor.step(3);
    expect_windows_apart(editor);
  }
}

TEST(Panels, APictureIsSavedInTheSizeThatIsAsked) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 1400.0f);
  editor.facts.scene = &scene;
  editor.state.right_tab = 1;
  editor.state.picture_file.width = 0;
  editor.state.picture_file.height = 1 << 20;
  editor.step(3);
  EXPECT_EQ(editor.state.picture_file.width, 1);
  EXPECT_EQ(editor.state.picture_file.height, 16384);
  EXPECT_FALSE(editor.actions.save_picture);
  ASSERT_TRUE(editor.click("file/png"));
  EXPECT_TRUE(editor.state.picture_file.png);
  ASSERT_TRUE(editor.click("file/save"));
  EXPECT_TRUE(editor.actions.save_picture);
}

TEST(Panels, APictureInWorkIsCancelled) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 1400.0f);
  editor.facts.scene = &scene;
  editor.state.right_tab = 1;
  editor.step(3);
  EXPECT_FALSE(editor.frame.items.contains("file/cancel"));
  editor.facts.picture_in_work = "look.exr";
  ASSERT_TRUE(editor.click("file/cancel"));
  EXPECT_TRUE(editor.actions.cancel_picture);
  EXPECT_FALSE(editor.frame.items.contains("file/save"));
}

TEST(Panels, EyeAndTargetAreSeenAndTyped) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 720.0f);
  editor.facts.scene = &scene;
  editor.state.camera.eye = {0.0f, 1.0f, 5.0f};
  editor.state.camera.target = {0.0f, 1.0f, 0.0f};
  editor.step(3);
  ASSERT_TRUE(editor.click("camera/eye/2"));
  ImGui::GetIO().KeyCtrl = true;
  editor.press(ImGuiKey_A);
  ImGui::GetIO().KeyCtrl = false;
  ImGui::GetIO().AddInputCharactersUTF8("2.5");
  editor.step(2);
  editor.press(ImGuiKey_Enter);
  EXPECT_EQ(editor.state.camera.eye, glm::vec3(0.0f, 2.5f, 5.0f));
  editor.state.camera.eye = {0.0f, 1.0f, 5.0f};
  ASSERT_TRUE(editor.click("camera/eye/3"));
  ImGui::GetIO().KeyCtrl = true;
  editor.press(ImGuiKey_A);
  ImGui::GetIO().KeyCtrl = false;
  ImGui::GetIO().AddInputCharactersUTF8("0");
  editor.step(2);
  editor.press(ImGuiKey_Enter);
  EXPECT_NE(editor.state.camera.eye, editor.state.camera.target) << "a camera looks somewhere";
}

TEST(Panels, TypedNumbersStayFinite) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 720.0f);
  editor.facts.scene = &scene;
  editor.step(3);
  ASSERT_TRUE(editor.click("camera/eye"));
  ImGui::GetIO().AddInputCharactersUTF8("1e39");
  editor.step(3);
  EXPECT_TRUE(std::isfinite(editor.state.camera.eye.x));
}

TEST(Panels, BakesCanBeStoppedAndMade) {
  const Scene scene = small_scene();
  FrameStats stats;
  stats.status.own_bakes["prt"] = {false, 0.3, BakeState::running, true};
  stats.status.visibility.wanted = true;
  HeadlessEditor editor(1280.0f, 900.0f);
  editor.facts.scene = &scene;
  editor.facts.stats = &stats;
  editor.facts.background = {{"prt", 0.3}};
  editor.facts.seconds_left["prt"] = 200.0;
  editor.state.right_tab = 2;
  editor.step(3);
  EXPECT_EQ(editor.frame.items.count("stop/visibility"), 0u);
  EXPECT_TRUE(editor.frame.items.contains("work/prt")) << "in the status bar";
  EXPECT_EQ(editor.frame.items.count("bake/prt"), 0u);
  ASSERT_TRUE(editor.click("stop/prt"));
  EXPECT_EQ(editor.state.settings.get_string("prt.run"), "hold");
  editor.facts.background.clear();
  editor.facts.seconds_left.clear();
  stats.status.own_bakes["prt"].state = BakeState::absent;
  EXPECT_FALSE(editor.click("stop/prt"));
  ASSERT_TRUE(editor.click("bake/prt"));
  EXPECT_EQ(editor.state.settings.get_string("prt.run"), "auto");
}

TEST(Panels, ABakeSaysWhetherItIsStopped) {
  const BakeStatus part{true, 0.3, BakeState::partial, true}, ready{true, 1.0, BakeState::ready, true},
      absent{false, 0.0, BakeState::absent, true};
  EXPECT_EQ(panels::bake_state_text(part, true, false), "in work; a part is shown");
  EXPECT_EQ(panels::bake_state_text(part, false, true), "stopped; a part is shown");
  EXPECT_EQ(panels::bake_state_text(absent, false, true), "stopped; nothing is baked");
  EXPECT_EQ(panels::bake_state_text(ready, false, false), "ready");
  EXPECT_EQ(panels::bake_state_text(ready, false, true), "held");
  EXPECT_EQ(panels::bake_state_text(ready, true, false), "in work; the last one is shown");
}

TEST(Panels, ABakeIsGivenThePartsThatAreChosen) {
  Scene scene = small_scene();
  scene.nodes.front().name = "seat";
  FrameStats stats;
  stats.status.own_bakes["slf"] = {true, 1.0, BakeState::absent, true};
  HeadlessEditor editor(1280.0f, 900.0f);
  editor.facts.scene = &scene;
  editor.facts.stats = &stats;
  editor.state.right_tab = 2;
  ASSERT_TRUE(editor.click("parts/add/slf"));
  EXPECT_EQ(editor.state.settings.get_string("slf.parts"), "") << "nothing is chosen";
  editor.state.selected_node = 0;
  ASSERT_TRUE(editor.click("parts/add/slf"));
  EXPECT_EQ(editor.state.settings.get_string("slf.parts"), "seat");
  ASSERT_TRUE(editor.click("parts/remove/slf"));
  EXPECT_EQ(editor.state.settings.get_string("slf.parts"), "seat") << "the last one stays: none would be all";
  editor.state.settings.set("slf.parts", std::string("wall;seat;lamp"));
  ASSERT_TRUE(editor.click("parts/remove/slf"));
  EXPECT_EQ(editor.state.settings.get_string("slf.parts"), "wall;lamp");
  ASSERT_TRUE(editor.click("parts/add/slf"));
  EXPECT_EQ(editor.state.settings.get_string("slf.parts"), "wall;lamp;seat");
  ASSERT_TRUE(editor.click("parts/all/slf"));
  EXPECT_EQ(editor.state.settings.get_string("slf.parts"), "");
}

}  // namespace
}  // namespace maquette
