#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "render/technique/registry.h"
#include "scenes/brdf.h"
#include "tests/ui/headless_editor.h"

namespace maquette {
namespace {

using test::HeadlessEditor;

Scene small_scene() {
  Scene scene;
  scene.name = "small.glb";
  for (const char* name : {"paint", "leather", "a material with a name that is much too long for its row"}) {
    Material material;
    material.name = name;
    scene.materials.push_back(material);
  }
  Mesh mesh;
  mesh.name = "door";
  mesh.primitives.resize(1);
  mesh.primitives[0].material = 1;
  scene.meshes.push_back(mesh);
  Node root, door;
  root.name = "car";
  root.children = {1};
  door.name = "door_left";
  door.parent = 0;
  door.mesh = 0;
  scene.nodes = {root, door};
  scene.roots = {0};
  scene.variants = {"base", "touring"};
  return scene;
}

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
  EXPECT_TRUE(editor.actions.dismiss_messages);
  messages[0].remedy.clear();
  editor.step(2);
  EXPECT_FALSE(editor.frame.items.contains("remedy"));
  EXPECT_TRUE(editor.frame.items.contains("dismiss"));
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

TEST(Panels, TheContrastIsOfWhatIsSeenOrOfAnObject) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 1400.0f);
  editor.facts.scene = &scene;
  editor.state.right_tab = 4;
  editor.step(3);
  EXPECT_FALSE(editor.frame.items.contains("inspection/background"));
  ASSERT_TRUE(editor.click("inspection/contrast"));
  editor.press(ImGuiKey_DownArrow);
  editor.press(ImGuiKey_Space);
  ASSERT_TRUE(editor.state.inspection.background_given);
  EXPECT_TRUE(editor.frame.items.contains("inspection/background"));
  EXPECT_TRUE(editor.frame.items.contains("inspection/eye box/2")) << "width and height";
}

TEST(Panels, AMeasurementInWorkCanBeCancelled) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 1400.0f);
  editor.facts.scene = &scene;
  editor.facts.inspection.sweep_names = sweep_names();
  editor.state.right_tab = 4;
  editor.step(3);
  EXPECT_FALSE(editor.frame.items.contains("inspection/cancel"));
  editor.facts.inspection.job = "Sweep of rake";
  editor.facts.inspection.job_share = 0.25f;
  editor.facts.inspection.job_seconds_left = 12.0;
  ASSERT_TRUE(editor.click("inspection/cancel"));
  EXPECT_TRUE(editor.actions.inspection.cancel);
  ASSERT_TRUE(editor.click("inspection/run"));
  EXPECT_FALSE(editor.actions.inspection.run_sweep) << "one at a time";
}

TEST(Panels, TheLegendHasItsNumbersWhereTheyBelong) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 720.0f);
  editor.facts.scene = &scene;
  editor.state.right_tab = 4;
  editor.state.inspection.false_color = true;
  for (const bool in_ev : {false, true}) {
    editor.state.inspection.in_ev = in_ev;
    editor.step(3);
    const Rect bar = editor.frame.items.at("inspection/legend");
    const auto text = [&](int i) { return editor.frame.items.at("inspection/legend/" + std::to_string(i)); };
    EXPECT_NEAR(text(0).x, bar.x, 1.0f);
    EXPECT_NEAR(text(1).x + 0.5f * text(1).width, bar.x + 0.5f * bar.width, 1.5f);
    EXPECT_NEAR(text(2).x + text(2).width, bar.x + bar.width, 1.5f);
  }
}

TEST(Panels, AKeyIsDraggedAlongTheTimeline) {
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

TEST(Panels, LateFramesDoNotMoveTheKeys) {
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

TEST(Panels, ALookHasANote) {
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

}  // namespace
}  // namespace maquette
