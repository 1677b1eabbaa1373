#include "viewer/inspection_options.h"

#include <gtest/gtest.h>

#include <array>

#include "viewer/session.h"

namespace maquette {
namespace {

TEST(InspectionOptions, ButtonsPutTheEyeWhereTheCommandDoes) {
  const VehicleAxes axes = vehicle_axes("-z,-x,+y");
  const glm::dvec3 r_point(0.37, 0.47, -0.23);
  InspectionView view;
  EXPECT_EQ(eye_of_button(1, view, r_point, axes), eye_from_r_point(r_point, axes, {"V1", false}));
  EXPECT_EQ(eye_of_button(2, view, r_point, axes), eye_from_r_point(r_point, axes, {"V2", false}));
  view.right_hand_drive = true;
  EXPECT_EQ(eye_of_button(1, view, r_point, axes), eye_from_r_point(r_point, axes, {"V1", true}));
  view = {};
  view.eye_mm = {100.0f, 20.0f, 640.0f};
  const glm::dvec3 own = eye_of_button(3, view, r_point, axes);
  EXPECT_NEAR(glm::distance(own, r_point + 0.1 * axes.rearward + 0.02 * axes.right + 0.64 * axes.up), 0.0, 1e-7);
  view.which_eye = 1;
  const glm::dvec3 left = eye_of_button(3, view, r_point, axes);
  view.which_eye = 2;
  const glm::dvec3 right = eye_of_button(3, view, r_point, axes);
  EXPECT_NEAR(glm::dot(right - left, axes.right), 0.065, 1e-9);
  EXPECT_NEAR(glm::distance(0.5 * (left + right), own), 0.0, 1e-9);
}

TEST(InspectionOptions, TheEyeKeepsTheDirectionOfTheCamera) {
  const VehicleAxes axes = vehicle_axes("-z,-x,+y");
  CameraView camera;
  camera.eye = {1.0f, 2.0f, 3.0f};
  camera.target = {0.25f, 1.5f, 4.0f};
  const CameraView at = camera_at_eye(camera, {0.36, 1.1, -0.3}, axes);
  EXPECT_NEAR(glm::distance(at.eye, glm::vec3(0.36f, 1.1f, -0.3f)), 0.0f, 1e-6f);
  EXPECT_NEAR(glm::distance(at.target - at.eye, camera.target - camera.eye), 0.0f, 1e-6f);
  EXPECT_EQ(at.up, glm::vec3(axes.up));
}

TEST(InspectionOptions, ConditionsAreThoseOfTheCommand) {
  InspectionView view;
  EXPECT_FALSE(measure_options_of(view).night);
  EXPECT_FALSE(measure_options_of(view).lux_on_glass);
  EXPECT_FALSE(measure_options_of(view).dash_reflectance);
  view.light = InspectionView::Light::given;
  view.dash_given = true;
  view.grid = {3, 2};
  view.both_eyes = true;
  view.polarisation = 3;
  view.threshold_cdm2 = 250.0f;
  view.eye_box_mm = {140.0f, 80.0f};
  EXPECT_FALSE(measure_options_of(view).background_cdm2) << "of what is seen";
  view.background_given = true;
  view.background_cdm2 = 2500.0f;
  const MeasureOptions options = measure_options_of(view);
  EXPECT_DOUBLE_EQ(options.lux_on_glass.value(), 88900.0);
  EXPECT_FLOAT_EQ(static_cast<float>(options.dash_reflectance.value()), 0.13f);
  EXPECT_EQ(options.grid_columns, 3);
  EXPECT_EQ(options.grid_rows, 2);
  EXPECT_TRUE(options.both_eyes);
  EXPECT_EQ(options.polarisation, Polarisation::sunglasses);
  EXPECT_EQ(options.threshold_cdm2, 250.0);
  EXPECT_EQ(options.eye_box_mm, glm::dvec2(140.0, 80.0));
  EXPECT_EQ(options.background_cdm2.value(), 2500.0);
  view.light = InspectionView::Light::night;
  EXPECT_TRUE(measure_options_of(view).night);
  EXPECT_FALSE(measure_options_of(view).lux_on_glass) << "the two exclude each other";
}

TEST(InspectionOptions, AReviewGivesWhatTheCommandDoesNotName) {
  Review review;
  review.inspection.threshold_cdm2 = 250.0f;
  review.inspection.eye_box_mm = {140.0f, 80.0f};
  review.inspection.grid = {3, 2};
  review.inspection.light = InspectionSetup::Light::night;
  review.inspection.r_point_m = {0.1f, 0.2f, 0.3f};
  review.regions = {{0.5f, 0.25f, 0.25f, 0.5f}};
  SceneOptions asked;
  asked.width = 80;
  asked.height = 40;
  Scene scene;
  MeasureOptions options = measure_options_of(review, scene, asked, {});
  EXPECT_EQ(options.threshold_cdm2, 250.0);
  EXPECT_EQ(options.eye_box_mm, glm::dvec2(140.0, 80.0));
  EXPECT_EQ(options.grid_columns, 3);
  EXPECT_TRUE(options.night);
  ASSERT_TRUE(options.r_point_m);
  ASSERT_EQ(options.regions.size(), 1u);
  EXPECT_EQ(options.regions[0].x, 40);
  EXPECT_EQ(options.regions[0].height, 20);

  asked.given = {"--threshold", "--lux-on-glass", "--eye-grid"};
  MeasureOptions given;
  given.threshold_cdm2 = 7.0;
  given.lux_on_glass = 500.0;
  given.regions = {{"low", 1, 2, 3, 4}};
  scene.nodes.resize(1);
  scene.nodes[0].name = "r_point";
  options = measure_options_of(review, scene, asked, given);
  EXPECT_EQ(options.threshold_cdm2, 7.0);
  EXPECT_EQ(options.grid_columns, 1);
  EXPECT_FALSE(options.night) << "another light was asked for";
  EXPECT_FALSE(options.r_point_m) << "the scene's node counts more";
  EXPECT_EQ(options.regions[0].name, "low");
}

TEST(InspectionOptions, IntervalsAreReadWithoutExponents) {
  EXPECT_EQ(interval_text({3989.2, 113.0}), "3989 +- 110 cd/m2");
  EXPECT_EQ(interval_text({115.53, 2.84}), "115.5 +- 2.8 cd/m2");
  EXPECT_EQ(interval_text({12627.0, 1e-6}), "12627 +- 0 cd/m2");
  EXPECT_EQ(interval_text({2.5e6, 12345.0}), "2500000 +- 12000 cd/m2");
}

TEST(InspectionOptions, TheWorstEyeOfEachStepCounts) {
  Measurement result;
  const auto add = [&](double step, double cdm2) {
    EyeValues eye;
    eye.eye = "row 1, column " + std::to_string(result.eyes.size() + 1);
    eye.step = {{"rake", step}};
    eye.regions.resize(1);
    eye.regions[0].reflected.mean = cdm2;
    result.eyes.push_back(eye);
  };
  add(45.0, 10.0);
  add(45.0, 12.0);
  add(60.0, 30.0);
  add(60.0, 20.0);
  result.worst = 2;
  EXPECT_EQ(worst_of_steps(result, {45.0f, 60.0f}, false), (std::vector<float>{12.0f, 30.0f}));
  const auto rows = worst_rows(result);
  ASSERT_GE(rows.size(), 2u);
  EXPECT_EQ(rows[0].second, "row 1, column 3, rake 60");
  EXPECT_EQ(rows[1].second.substr(0, 8), "30 cd/m2");
  EXPECT_TRUE(worst_rows({}).empty());
  const std::array<double, 4> angles = {3.0, 2.0, 4.0, 6.0};
  for (std::size_t i = 0; i < angles.size(); ++i) {
    result.eyes[i].regions[0].ghost_arcmin.emplace();
    result.eyes[i].regions[0].ghost_arcmin->mean = angles[i];
  }
  EXPECT_EQ(worst_of_steps(result, {45.0f, 60.0f}, true), (std::vector<float>{3.0f, 6.0f}));
  for (const std::string& name : sweep_names())
    EXPECT_EQ(changes_glass_alone(name), name == "wedge" || name == "thickness") << name;
}

TEST(InspectionOptions, AWindowsTabMeasuresWhatItsWindowShows) {
  Scene scene;
  scene.variants = {"Day", "Night"};
  Look shown;
  shown.edits.variant = "Night";
  shown.edits.env_rotation_deg = 20.0f;
  shown.edits.env_scale = 2.0f;
  shown.edits.section = {1.0f, 0.0f, 0.0f, 0.5f};
  shown.settings.set("reflections.wedge", 0.5);
  shown.settings.set("reflections.layer", std::string("ghost"));
  shown.camera.eye = {1.0f, 2.0f, 3.0f};
  shown.camera.target = {0.0f, 1.0f, 0.0f};
  shown.camera.fov_y_rad = 0.4f;
  for (const float height_m : {0.0f, 1.5f}) {
    shown.camera.height_m = height_m;
    const SceneOptions options = inspected_options(shown, "car.glb");
    const Look measured = look_of_options(scene, options);
    EXPECT_EQ(measured.edits, shown.edits);
    EXPECT_EQ(measured.camera.eye, shown.camera.eye);
    EXPECT_EQ(measured.camera.target, shown.camera.target);
    EXPECT_EQ(measured.camera.height_m, height_m);
    if (height_m == 0.0f) {
      EXPECT_NEAR(measured.camera.fov_y_rad, shown.camera.fov_y_rad, 1e-6f);
    }
    EXPECT_EQ(measured.settings.get_double("reflections.wedge"), 0.5);
    EXPECT_EQ(measured.settings.get_string("reflections.layer"), "all") << "every layer is measured";
  }
}

TEST(InspectionOptions, RegionsCoverAtLeastAPixel) {
  EXPECT_EQ(pixels_of({0.25f, 0.5f, 0.5f, 0.25f}, 80, 40), glm::ivec4(20, 20, 40, 10));
  EXPECT_EQ(pixels_of({0.5f, 0.5f, 0.001f, 0.001f}, 80, 40), glm::ivec4(40, 20, 1, 1));
  EXPECT_EQ(pixels_of({0.0f, 0.0f, 1.0f, 1.0f}, 80, 40), glm::ivec4(0, 0, 80, 40));
}

}  // namespace
}  // namespace maquette
