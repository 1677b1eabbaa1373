// The inspection story in the real window: the eye at V1, a probe, false colours, a region, a sweep, files.
#include <gtest/gtest.h>

#include <filesystem>

#include "review/json_reader.h"
#include "tests/ui/story_fixture.h"
#include "viewer/measure/measure_run.h"

namespace maquette {
namespace {

class InspectionStory : public Story {
 protected:
  bool eye_is_at(const glm::dvec3& eye) {
    return wait_for_review([&](const Review& r) { return glm::distance(glm::dvec3(r.look.camera.eye), eye) < 1e-5; });
  }
};

TEST_F(InspectionStory, EyeProbeRegionSweepExport) {
  const Scene scene = load_scene("builtin:cockpit");
  Controls at = controls(scene);
  at.facts().inspection.has_r_point = true;
  at.facts().inspection.sweep_names = sweep_names();
  const Rect picture = at.picture(), middle = middle_of(picture);
  std::vector<std::string> arguments = {"builtin:cockpit", "--reflections", "raytraced"};
  if (pictures_.empty())  // the manual's have all of their light
    arguments.insert(arguments.end(), {"--set", "shading.visibility=none", "--set", "shading.indirect=none"});
  begin(arguments);
  ASSERT_TRUE(wait_for_picture(middle)) << desktop_->errors();
  const ScreenPicture closed = desktop_->grab();
  desktop_->click(at.item("tab/Inspect"));
  at.state().right_tab = 4;
  ASSERT_TRUE(wait_for_change(closed, at.item("inspection/Regions"), 1.0)) << "the tab opens";

  press(&at, "inspection/v2");
  const VehicleAxes axes = vehicle_axes("-z,-x,+y");
  const glm::dvec3 r_point(0.37, 0.47, -0.23);
  EXPECT_TRUE(eye_is_at(eye_from_r_point(r_point, axes, {"V2", false})));
  press(&at, "inspection/v1");
  EXPECT_TRUE(eye_is_at(eye_from_r_point(r_point, axes, {"V1", false})));
  const ScreenPicture plain = settled();

  const Rect corner{picture.x + 10.0f, picture.y + picture.height - 120.0f, 180.0f, 100.0f};
  desktop_->move(picture.x + 0.5f * picture.width, picture.y + 0.55f * picture.height);
  EXPECT_TRUE(wait_for_change(plain, corner, 5.0)) << "the probe says what is under the mouse";
  keep_screen("inspection-probe");
  desktop_->move(picture.x - 40.0f, picture.y + 0.5f * picture.height);
  press(&at, "inspection/false colors");
  EXPECT_TRUE(wait_for_change(plain, middle, 10.0)) << "false colours";
  keep_screen("inspection-colors");
  press(&at, "inspection/false colors");

  press(&at, "inspection/region");
  const float x = picture.x + 0.3f * picture.width, y = picture.y + 0.4f * picture.height;
  drag(x, y, x + 0.3f * picture.width, y + 0.2f * picture.height);
  // The journal has it while it is still drawn.
  ASSERT_TRUE(wait_for_review([](const Review& r) { return r.regions.size() == 1 && r.regions[0].width > 0.28f; }))
      << "the review keeps the region";
  const InspectedRegion region = review()->regions[0];
  EXPECT_NEAR(region.x, 0.3f, 0.01f);
  EXPECT_NEAR(region.width, 0.3f, 0.02f);
  at.state().tool = Tool::camera;
  at.state().inspection.regions = {region};

  for (const char* part : {"inspection/Eye", "inspection/Luminance", "inspection/Regions"}) press(&at, part);
  type_into(&at, "inspection/eye box", "140");
  EXPECT_TRUE(wait_for_review([](const Review& r) { return r.inspection.eye_box_mm[0] == 140.0f; }))
      << "and the size of the eye box";
  key("Return");
  press(&at, "inspection/Conditions");
  press(&at, "inspection/run");
  press(&at, "inspection/Trends");
  const std::string file = (folder_ / "windshield.csv").string();
  type_into(&at, "inspection/path", file);
  // The button works once the sweep has ended.
  ASSERT_TRUE(wait_for([&] {
    press(&at, "inspection/export");
    return std::filesystem::exists(file);
  })) << desktop_->errors();
  ASSERT_TRUE(wait_for_file(folder_ / "windshield.exr"));
  const ScreenPicture before = desktop_->grab();
  press(&at, "inspection/Trends");
  at.facts().inspection.sweep_x = at.facts().inspection.sweep_y = {1.0f, 3.0f, 2.0f};
  const Rect plot = at.item("inspection/plot");
  EXPECT_TRUE(wait_for([&] { return difference(before, desktop_->grab(), plot) > 2.0; })) << "the trend is plotted";
  keep_screen("inspection-trend");
  const std::string table = read_text_file(file);
  EXPECT_NE(table.find("scatter"), std::string::npos) << "what is not modelled is said:\n" << table;
  EXPECT_TRUE(desktop_->running());
  key("ctrl+q");
  EXPECT_EQ(desktop_->wait_for_exit(), 0) << desktop_->errors();
}

}  // namespace
}  // namespace maquette
