// The tab Inspect without a window.
#include <gtest/gtest.h>

#include "review/inspection_setup.h"
#include "tests/ui/headless_editor.h"
#include "tests/ui/small_scene.h"
#include "viewer/measure/measure_options.h"

namespace maquette {
namespace {

using test::HeadlessEditor;
using test::small_scene;

TEST(InspectionPanel, TheContrastIsOfWhatIsSeenOrOfAnObject) {
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

TEST(InspectionPanel, AMeasurementInWorkCanBeCancelled) {
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

TEST(InspectionPanel, AnotherQuantityIsVariedOverItsOwnRange) {
  const Scene scene = small_scene();
  HeadlessEditor editor(1280.0f, 1400.0f);
  editor.facts.scene = &scene;
  editor.facts.inspection.sweep_names = sweep_names();
  editor.state.right_tab = 4;
  editor.state.inspection.sweep_range = {12.0f, 34.0f};
  editor.step(3);
  ASSERT_TRUE(editor.click("inspection/sweep"));
  editor.press(ImGuiKey_DownArrow);
  editor.press(ImGuiKey_DownArrow);
  editor.press(ImGuiKey_Enter);
  ASSERT_NE(editor.state.inspection.sweep, 0);
  EXPECT_EQ(editor.state.inspection.sweep_range, usual_range(editor.state.inspection.sweep));
  for (std::size_t i = 0; i < sweep_names().size(); ++i)
    for (const float value : usual_range(static_cast<int>(i)))
      EXPECT_NO_THROW(check_sweep_value(sweep_names()[i], static_cast<double>(value)));
}

TEST(InspectionPanel, TheLegendHasItsNumbersWhereTheyBelong) {
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

}  // namespace
}  // namespace maquette
