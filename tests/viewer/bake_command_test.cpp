// `maquette bake` as users and mpirun call it.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "render/technique/settings.h"
#include "scenes/bake_file.h"
#include "test_paths.h"
#include "tests/support/test_scenes.h"
#include "tests/viewer/run_program.h"

namespace maquette {
namespace {

using Words = std::vector<std::string>;

/// A few hundred texels of a sphere of few directions.
Words with_light_field(Words words, const Words& more) {
  words.insert(words.end(), {"builtin:sphere", "--set", "slf.texels=48", "--set", "slf.directions=4", "--set",
                             "slf.paths=1", "--env", "builtin:studio"});
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

ProgramResult bake(const Words& more) { return run_maquette(with_light_field({"bake", "slf"}, more)); }

ProgramResult render(const TemporaryFolder& folder, const Words& more) {
  return run_maquette(with_light_field(
      {"render", "--mode", "slf", "--size", "16x12", "-o", folder.file("a.exr"), "--set", "ground.kind=none"}, more));
}

TEST(BakeCommand, LightIsBakedAsTheRenderHasIt) {
  const TemporaryFolder folder;
  const std::string at = folder.file("turned");
  ProgramResult result = bake({"--env-rotation", "30", "--env-scale", "2", "-o", at});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const Words shown{"--set", "slf.bake=" + at};
  const auto with = [&](Words more) {
    more.insert(more.end(), shown.begin(), shown.end());
    return render(folder, more);
  };
  result = with({"--env-rotation", "30"});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.error.find("stale"), std::string::npos) << result.error;
  EXPECT_NE(result.error.find("--env-rotation"), std::string::npos) << "and how it is made anew: " << result.error;
  result = with({"--env-rotation", "30", "--env-scale", "2"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  // The folder inside is taken as well.
  result = render(folder, {"--env-rotation", "30", "--env-scale", "2", "--set", "slf.bake=" + at + "/sphere-slf"});
  EXPECT_EQ(result.exit_code, 0) << result.error;
}

TEST(BakeCommand, TheFolderKnowsItsSettings) {
  const TemporaryFolder folder;
  const std::string at = folder.file("baked");
  ASSERT_EQ(bake({"-o", at}).exit_code, 0);
  const auto draw = [&](const Words& more) {
    Words words = {"render", "builtin:sphere",
                   "--mode", "slf",
                   "--size", "16x12",
                   "--env",  "builtin:studio",
                   "-o",     folder.file("b.exr"),
                   "--set",  "ground.kind=none",
                   "--set",  "slf.bake=" + at};
    words.insert(words.end(), more.begin(), more.end());
    return run_maquette(words);
  };
  const ProgramResult plain = draw({}), same = draw({"--set", "slf.directions=4"}),
                      other = draw({"--set", "slf.texels=64"});
  EXPECT_EQ(plain.exit_code, 0) << plain.error;
  EXPECT_EQ(same.exit_code, 0) << same.error;
  EXPECT_EQ(other.exit_code, 2) << "both are given, and differ";
  const int usual = Settings().get_int("slf.directions");
  ASSERT_NE(usual, 4);
  const ProgramResult as_declared = draw({"--set", "slf.directions=" + std::to_string(usual)});
  EXPECT_EQ(as_declared.exit_code, 2) << "what is declared is given too";
  EXPECT_NE(as_declared.error.find("was made with 4"), std::string::npos) << as_declared.error;
  EXPECT_EQ(bake({"-o", at, "--set", "slf.paths=" + std::to_string(Settings().get_int("slf.paths"))}).exit_code, 2);
  // The same command without the settings resumes.
  const ProgramResult again = run_maquette({"bake", "slf", "builtin:sphere", "--env", "builtin:studio", "-o", at});
  EXPECT_EQ(again.exit_code, 0) << again.error;
  // The same with radiance transfer.
  Scene floor;
  floor.materials = {test::matte(glm::vec3(0.5f))};
  test::add(&floor, test::make_grid({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 2, 0), "floor");
  save_glb(folder.file("floor.glb"), floor);
  const std::string transfer = folder.file("transfer");
  const ProgramResult made = run_maquette(
      {"bake", "prt", folder.file("floor.glb"), "--set", "prt.rays=2", "--set", "prt.faces=4", "-o", transfer});
  ASSERT_EQ(made.exit_code, 0) << made.error;
  const ProgramResult shown =
      run_maquette({"render", folder.file("floor.glb"), "--mode", "prt", "--size", "16x12", "-o", folder.file("c.exr"),
                    "--set", "ground.kind=none", "--set", "prt.bake=" + transfer});
  EXPECT_EQ(shown.exit_code, 0) << shown.error;
}

TEST(BakeCommand, LightOfOtherMaterialsNeedsAFolder) {
  const TemporaryFolder folder;
  const Words other{"--material", "*=builtin:fabric-grey"};
  ProgramResult result = bake(other);
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_NE(result.error.find("name a folder"), std::string::npos) << result.error;
  const std::string at = folder.file("covered");
  result = bake({other[0], other[1], "-o", at});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  // Shown with the materials that it was baked with, nothing has been exchanged.
  const std::string shown = "slf.bake=" + at;
  result = render(folder, {other[0], other[1], "--set", shown});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(result.error.find("exchanged"), std::string::npos) << result.error;
  result = render(folder, {"--set", shown});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_NE((result.out + result.error).find("exchanged"), std::string::npos) << result.out << result.error;
}

TEST(BakeCommand, ATextureThatWasPaintedOverIsExchanged) {
  const TemporaryFolder folder;
  const std::string at = folder.file("baked"), scene = folder.file("floor.glb");
  const auto save = [&](std::uint8_t grey) {
    Scene floor;
    floor.materials = {test::matte(glm::vec3(0.5f))};
    floor.materials[0].name = "carpet";
    floor.images = {{"weave", 2, 2, std::vector<std::uint8_t>(16, grey)}};
    floor.materials[0].base_color_texture.image = 0;
    test::add(&floor, test::make_grid({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 2, 0), "floor");
    save_glb(scene, floor);
  };
  save(200);
  const ProgramResult made = run_maquette({"bake", "slf", scene, "--env", "builtin:studio", "-o", at, "--set",
                                           "slf.texels=16", "--set", "slf.directions=4", "--set", "slf.paths=1"});
  ASSERT_EQ(made.exit_code, 0) << made.error;
  const auto draw = [&] {
    return run_maquette({"render", scene, "--mode", "slf", "--size", "16x12", "--env", "builtin:studio", "-o",
                         folder.file("a.exr"), "--set", "ground.kind=none", "--set", "slf.bake=" + at});
  };
  const ProgramResult same = draw();
  EXPECT_EQ(same.exit_code, 0) << same.error;
  EXPECT_EQ(same.error.find("exchanged"), std::string::npos) << same.error;
  save(100);
  const ProgramResult painted = draw();
  EXPECT_EQ(painted.exit_code, 0) << painted.error;
  EXPECT_NE(painted.error.find("exchanged since the bake: carpet"), std::string::npos) << painted.out << painted.error;
}

TEST(BakeCommand, PartsThatExchangeTheirMaterialsAreNamed) {
  const TemporaryFolder folder;
  const std::string at = folder.file("baked"), scene = folder.file("floor.glb");
  const auto save = [&](int left) {
    Scene floor;
    floor.materials = {test::matte(glm::vec3(0.8f)), test::matte(glm::vec3(0.1f))};
    test::add(&floor, test::make_grid({-1, 0, 1}, {1, 0, 0}, {0, 0, -2}, 2, left), "left");
    test::add(&floor, test::make_grid({0, 0, 1}, {1, 0, 0}, {0, 0, -2}, 2, 1 - left), "right");
    save_glb(scene, floor);
  };
  const Words few = {"--env", "builtin:studio",   "--set", "slf.texels=16",
                     "--set", "slf.directions=4", "--set", "slf.paths=1"};
  const auto draw = [&](const Words& more) {
    Words words = {"render",          scene, "--mode", "slf", "--size", "16x12", "-o", folder.file("a.exr"), "--set",
                   "ground.kind=none"};
    words.insert(words.end(), few.begin(), few.end());
    words.insert(words.end(), more.begin(), more.end());
    return run_maquette(words, {{"MAQUETTE_CACHE", folder.file("cache")}});
  };
  save(0);
  Words bake = {"bake", "slf", scene, "-o", at};
  bake.insert(bake.end(), few.begin(), few.end());
  ASSERT_EQ(run_maquette(bake).exit_code, 0);
  const auto fields = [&] {
    int count = 0;
    for (const auto& entry : std::filesystem::directory_iterator(folder.file("cache")))
      count += entry.path().filename().string().starts_with("slf-") ? 1 : 0;
    return count;
  };
  ASSERT_EQ(draw({}).exit_code, 0);
  EXPECT_EQ(fields(), 1);
  save(1);
  const ProgramResult exchanged = draw({"--set", "slf.bake=" + at});
  EXPECT_NE(exchanged.error.find("the material of /left, the material of /right"), std::string::npos)
      << exchanged.error;
  ASSERT_EQ(draw({}).exit_code, 0);
  EXPECT_EQ(fields(), 2) << "another key in the cache";
}

TEST(BakeCommand, WhatNoBakeReadsIsSaid) {
  const TemporaryFolder folder;
  const ProgramResult result = run_maquette({"bake", "octree", "builtin:sphere", "--set", "octree.depth=4",
                                             "--env-rotation", "30", "-o", folder.file("tree")});
  EXPECT_EQ(result.exit_code, 0) << result.error;
  EXPECT_NE(result.error.find("depends on no environment"), std::string::npos) << result.error;
}

TEST(BakeCommand, InspectTabulatesTheLightThatLeaves) {
  const TemporaryFolder folder;
  const std::string at = folder.file("bake");
  ASSERT_EQ(bake({"-o", at}).exit_code, 0);
  const ProgramResult result = run_maquette({"inspect", at, "--json"});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_NE(result.out.find("of_light_that_leaves"), std::string::npos) << result.out;
  EXPECT_EQ(result.out.find("list."), std::string::npos) << "hashes are no figures: " << result.out;
  const ProgramResult other = run_maquette({"inspect", at, "builtin:seat", "--json"});
  EXPECT_EQ(other.exit_code, 0) << other.error;
  EXPECT_NE(other.out.find("of_light_that_arrives"), std::string::npos) << "another scene: " << other.out;
}

TEST(BakeCommand, TheReportMeasuresABakeThatIsNamed) {
  const TemporaryFolder folder;
  const std::string at = folder.file("bake");
  ASSERT_EQ(bake({"-o", at}).exit_code, 0);
  const ProgramResult result = run_maquette(
      with_light_field({"report", "--size", "24x16", "--repeats", "1", "--budget", "90", "-o", folder.file("report")},
                       {"--set", "slf.bake=" + at}));
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const auto json = nlohmann::json::parse(read_text(folder.file("report/report.json")));
  int points = 0;
  for (const auto& point : json.at("points")) points += point.at("technique") == "slf" ? 1 : 0;
  EXPECT_GE(points, 1);
  for (const auto& left_out : json.at("left_out"))
    if (left_out.at("technique") == "prt" && left_out.at("what") == "prt") {
      EXPECT_NE(left_out.at("why").get<std::string>().find("maquette bake prt"), std::string::npos);
    }
}

/// Of the columns of all blocks, in the order of their names.
std::vector<float> light_in(const std::string& folder) {
  std::vector<std::string> files;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) files.push_back(entry.path().string());
  std::sort(files.begin(), files.end());
  std::vector<float> light;
  for (const std::string& file : files) {
    if (file.find("incident-") == std::string::npos) continue;
    const BakeFile block = load_bake_file(file);
    for (const char* channel : {"R", "G", "B"}) {
      const std::vector<float>& values = block.floats(file, "radiance", channel);
      light.insert(light.end(), values.begin(), values.end());
    }
  }
  return light;
}

TEST(BakeCommand, ProcessesOfMpirunShareABake) {
  if (std::system("mpirun --version >/dev/null 2>&1") != 0) GTEST_SKIP() << "mpirun is not there (openmpi-bin)";
  const TemporaryFolder folder;
  const Words sized{"--set", "slf.texels=96"};
  ASSERT_EQ(bake({sized[0], sized[1], "-o", folder.file("one")}).exit_code, 0);
  Words words{"--allow-run-as-root", "--oversubscribe", "-n", "3", MAQUETTE_PROGRAM};
  const Words call = with_light_field({"bake", "slf"}, {sized[0], sized[1], "-o", folder.file("three")});
  words.insert(words.end(), call.begin(), call.end());
  const ProgramResult result = run_in_folder(folder.path().string(), "mpirun", words);
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const std::vector<float> one = light_in(folder.file("one/sphere-slf"));
  EXPECT_GT(one.size(), 1000u);
  EXPECT_EQ(one, light_in(folder.file("three/sphere-slf")));
}

}  // namespace
}  // namespace maquette
