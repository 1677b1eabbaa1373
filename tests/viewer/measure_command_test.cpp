// The whole command: night, grids of eyes, sweeps, files; and calls that are wrong.
#include <gtest/gtest.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "review/review.h"
#include "tests/support/test_scenes.h"
#include "tests/viewer/run_program.h"
#include "ui/inspection_state.h"
#include "viewer/session.h"

namespace maquette {
namespace {

using Json = nlohmann::json;
using Words = std::vector<std::string>;

Words measure_words(const Words& more) {
  Words words = {"measure", "--mode", "reference", "--size", "48x27", "--eye-point", "V1"};
  if (std::ranges::find(more, "--samples") == more.end()) words.insert(words.end(), {"--samples", "1"});
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

Json measured(const TemporaryFolder& folder, Words more) {
  more.insert(more.end(), {"-o", folder.file("m.json")});
  const ProgramResult result = run_maquette(measure_words(more));
  EXPECT_EQ(result.exit_code, 0) << result.error;
  return Json::parse(read_text(folder.file("m.json")));
}

TEST(MeasureCommand, AGridOfBothEyesNamesTheWorst) {
  const TemporaryFolder folder;
  const Json json = measured(folder, {"--eye-grid", "2x1", "--both-eyes"});
  const Json& eyes = json.at("eyes");
  ASSERT_EQ(eyes.size(), 4u) << json.dump(1);
  double worst = 0.0;
  for (const Json& eye : eyes)
    worst = std::max(worst, eye.at("regions").at(0).at("reflected_cdm2").at("mean").get<double>());
  EXPECT_EQ(json.at("worst").at("reflected_cdm2").get<double>(), worst);
}

TEST(MeasureCommand, AReviewIsMeasuredAsTheWindowInspectsIt) {
  const TemporaryFolder folder;
  Review review;
  review.look.camera = camera_by_name(load_scene(review.scene), "driver");
  review.inspection.threshold_cdm2 = 250.0f;
  review.inspection.light = InspectionSetup::Light::given;
  review.inspection.lux_on_glass = 5000.0f;
  review.inspection.grid = {2, 1};
  review.inspection.eye_box_mm = {140.0f, 0.0f};
  const std::string file = folder.file("car.maquette.json");
  save_review(file, review);
  const Json json = measured(folder, {file});
  EXPECT_EQ(json.at("assumptions").at("threshold"), "250 cd/m2") << json.dump(1);
  const Json& eyes = json.at("eyes");
  ASSERT_EQ(eyes.size(), 2u);
  EXPECT_NEAR(eyes.at(0).at("light_on_glass").at("illuminance_lx").get<double>(), 5000.0, 1.0);
  EXPECT_NE(json.at("assumptions").at("eye box").get<std::string>().find("140 x 0 mm"), std::string::npos);
  EXPECT_EQ(measured(folder, {file, "--threshold", "7"}).at("assumptions").at("threshold"), "7 cd/m2");
}

TEST(MeasureCommand, AtNightTheDisplaysAloneAreSeen) {
  const TemporaryFolder folder;
  const Json day = measured(folder, {}), night = measured(folder, {"--night"});
  const auto through = [](const Json& json) {
    return json.at("eyes").at(0).at("regions").at(0).at("transmitted_cdm2").at("mean").get<double>();
  };
  EXPECT_GT(through(day), 1000.0);
  EXPECT_LT(through(night), 1.0);
}

// Every figure can be had again from its file: what was changed, where the eye is, which settings are not as declared.
TEST(MeasureCommand, FilesSayWhatTheirFiguresRestOn) {
  const TemporaryFolder folder;
  const Json json = measured(
      folder, {"--material", "SoftTouch=builtin:paint-solid-white", "--turn", "mirror_glass_left=0,1,0,5", "--dent",
               "0.3,0.9,0.7,0.01,0.7", "--section", "0,1,0,1.5", "--set", "reflections.wedge=0.5", "--seed", "3"});
  const Json& said = json.at("assumptions");
  const auto text = [&](const char* name) { return said.value(name, std::string("(missing)")); };
  EXPECT_EQ(text("materials"), "SoftTouch=builtin:paint-solid-white");
  EXPECT_NE(text("turned parts").find("mirror_glass_left by 5 degrees about 0, 1, 0"), std::string::npos)
      << text("turned parts");
  EXPECT_EQ(text("dents"), "0.01 m deep, radius 0.7 m, at 0.3, 0.9, 0.7");
  EXPECT_EQ(text("section plane"), "what is seen has p . (0, 1, 0) <= 1.5 m");
  EXPECT_EQ(text("settings"), "reflections.wedge=0.5");
  EXPECT_EQ(text("samples"), "1 paths a pixel and side of the pane, seed 3");
  const Json& position = json.at("eyes").at(0).at("position_m");
  const std::string csv = folder.file("m.csv"), exr = folder.file("m.exr");
  const ProgramResult result = run_maquette(measure_words({"--sweep", "thickness=4,5", "-o", csv, "--layers", exr}));
  ASSERT_EQ(result.exit_code, 0) << result.error;
  char eye[96];
  std::snprintf(eye, sizeof eye, "region,V1,%.7g,%.7g,%.7g,4,pane", position[0].get<double>(),
                position[1].get<double>(), position[2].get<double>());
  EXPECT_NE(read_text(csv).find(eye), std::string::npos) << eye;
  EXPECT_NE(read_text(csv).find("# R-point: "), std::string::npos);
  EXPECT_NE(read_text(exr).find("V1: eye "), std::string::npos);
  EXPECT_NE(read_text(exr).find("thickness 5"), std::string::npos) << "the layers are of the last step";
}

// Where a step of a sweep turns the pane out of the picture, nothing is measured; the other steps keep their values.
TEST(MeasureCommand, AStepThatDoesNotShowThePaneLosesNoOther) {
  const TemporaryFolder folder;
  Scene scene;
  scene.materials = {test::matte(glm::vec3(0.3f)), {}};
  scene.materials[1].name = "glass";
  scene.materials[1].glass = true;
  scene.materials[1].transmission = 1.0f;
  scene.materials[1].roughness = 0.0f;
  scene.materials[1].metallic = 0.0f;
  test::add(&scene, test::make_grid({-0.5f, -0.5f, -0.8f}, {1, 0, 0}, {0, 0, -0.6f}, 1, 0), "dash");
  test::add(&scene, test::make_grid({-0.5f, -0.433f, -0.75f}, {1, 0, 0}, {0, 0.866f, 0.5f}, 1, 1), "windshield");
  save_glb(folder.file("a.glb"), scene);
  const Words words = {"measure", folder.file("a.glb"), "--eye", "0,0,0", "--target",           "0,0,-1", "--size",
                       "24x16",   "--samples",          "1",     "-o",    folder.file("m.csv"), "--sweep"};
  const auto sweep = [&](const char* range) {
    Words all = words;
    all.push_back(range);
    return run_maquette(all);
  };
  const ProgramResult result = sweep("rake=30,65");
  EXPECT_EQ(result.exit_code, 0) << result.error;
  const std::string table = read_text(folder.file("m.csv"));
  EXPECT_NE(table.find(",65,pane,0,0,"), std::string::npos) << table;
}

// The veil does not depend on the wedge; the ghost does.
TEST(MeasureCommand, TheWorstWedgeIsTheOneWithTheLargestGhost) {
  const TemporaryFolder folder;
  const Json json = measured(folder, {"--sweep", "wedge=1,-1,0"});
  EXPECT_EQ(json.at("worst").at("step").at("wedge").get<double>(), -1.0) << json.at("worst").dump();
  const Json& eyes = json.at("eyes");
  const auto ghost = [&](std::size_t i) {
    return eyes.at(i).at("regions").at(0).at("ghost_angle_arcmin").at("mean").get<double>();
  };
  EXPECT_GT(ghost(1), ghost(2));
  EXPECT_GT(ghost(2), ghost(0));
  EXPECT_EQ(json.at("worst").at("ghost_angle_arcmin").get<double>(), ghost(1));
}

// Turned flat, the pane lies below the eye, which then looks at its outer face.
TEST(MeasureCommand, AStepThatTheEyeDoesNotLookThroughIsNotTheWorst) {
  const TemporaryFolder folder;
  const Json json = measured(folder, {"--sweep", "rake=60,76,84"});
  const Json& eyes = json.at("eyes");
  ASSERT_TRUE(eyes.at(0).at("looks_through_pane").get<bool>());
  EXPECT_FALSE(eyes.at(1).at("looks_through_pane").get<bool>()) << "a part of it is past the eye";
  EXPECT_FALSE(eyes.at(2).at("looks_through_pane").get<bool>());
  EXPECT_EQ(json.at("worst").at("step").at("rake").get<double>(), 60.0);
  for (const Json& eye : eyes)  // of the same outer face, whichever side the eye is on
    EXPECT_NEAR(eye.at("light_on_glass").at("rake_deg").get<double>(), eye.at("step").at("rake").get<double>(), 0.5);
}

// The order that is known from measurements: a flatter windshield and a brighter dashboard veil more.
TEST(MeasureCommand, TheVeilGrowsWithRakeAndWithTheDashboard) {
  const TemporaryFolder folder;
  const Json json = measured(folder, {"--samples", "2", "--lux-on-glass", "88900", "--sweep", "rake=45,60,70",
                                      "--sweep", "dash-reflectance=0.13,0.20,0.34"});
  const Json& eyes = json.at("eyes");
  ASSERT_EQ(eyes.size(), 9u);
  const auto veil = [&](int rake, int dash) {
    return eyes.at(static_cast<std::size_t>(3 * rake + dash))
        .at("regions")
        .at(0)
        .at("reflected_cdm2")
        .at("mean")
        .get<double>();
  };
  for (int rake = 0; rake < 3; ++rake)
    for (int dash = 0; dash < 3; ++dash) {
      const double before = std::max(rake > 0 ? veil(rake - 1, dash) : 0.0, dash > 0 ? veil(rake, dash - 1) : 0.0);
      EXPECT_GT(veil(rake, dash), 1.2 * before) << rake << ", " << dash;
    }
  // What is lit sends back in proportion to its reflectance; what it mirrors besides does not come with it.
  for (int rake = 0; rake < 3; ++rake) EXPECT_NEAR(veil(rake, 2) / veil(rake, 0), 0.34 / 0.13, 0.35) << rake;
}

TEST(MeasureCommand, WrongCallsAreNamed) {
  const TemporaryFolder folder;
  struct Case {
    Words words;
    int exit_code;
    std::string error;
  };
  const std::vector<Case> cases = {
      {measure_words({"--region", "a=40,20,20,20"}), 2, "it reaches outside the picture of 48x27"},
      {measure_words({"--eye-grid", "0x2"}), 2, "it goes from 1 to 32"},
      {measure_words({"--sweep", "rakes=1,2"}), 2, "did you mean rake?"},
      {measure_words({"--sweep", "rake="}), 2, "--sweep"},
      {measure_words({"--dash", "SoftTuch"}), 2,
       "--dash SoftTuch: builtin:cockpit has no such material; did you mean SoftTouch?"},
      {measure_words({"--dash", "*"}), 2, "--dash *: builtin:cockpit has no such material"},
      {measure_words({"--night", "--lux-on-glass", "1000"}), 2, "it excludes --lux-on-glass"},
      {{"measure", "builtin:plate", "--eye-point", "V1"}, 1, "has no node r_point; give the R-point"},
      {{"measure", "builtin:plate"}, 1, "no pixel shows a pane of glass"}};
  for (const Case& c : cases) {
    const ProgramResult result = run_maquette(c.words);
    EXPECT_EQ(result.exit_code, c.exit_code) << result.error;
    EXPECT_NE(result.error.find(c.error), std::string::npos) << result.error;
    EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << result.error;
  }
}

TEST(PlainNumber, HasNoExponentWherePeopleReadIt) {
  EXPECT_EQ(plain_number(88900.0), "88900");
  EXPECT_EQ(plain_number(1234567.0), "1234567");
  EXPECT_EQ(plain_number(561.23), "561.2");
  EXPECT_EQ(plain_number(0.0316228), "0.03162");
  EXPECT_EQ(plain_number(0.0), "0");
  EXPECT_EQ(plain_number(-12345.6), "-12346");
}

}  // namespace
}  // namespace maquette
