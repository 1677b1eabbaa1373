#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "scenes/image_io.h"
#include "test_paths.h"
#include "tests/support/text.h"
#include "tests/viewer/run_program.h"

namespace maquette {
namespace {

using Json = nlohmann::json;
using Words = std::vector<std::string>;

using test::contains;

/// Runs and expects a failure with one line on standard error that contains `part`.
void expect_failure(const Words& words, int code, const std::string& part,
                    const std::map<std::string, std::string>& environment = {}) {
  const ProgramResult result = run_maquette(words, environment);
  std::string call = "maquette";
  for (const std::string& word : words) call += " " + word;
  EXPECT_EQ(result.exit_code, code) << call << "\n" << result.error;
  EXPECT_TRUE(contains(result.error, part)) << call << "\n" << result.error;
  EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << call << "\n" << result.error;
}

Words small_render(const TemporaryFolder& folder, const std::string& output, const Words& more = {}) {
  Words words = {"render", "builtin:sphere", "--size", "32x24", "--samples", "8", "--output", folder.file(output)};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

TEST(Program, UsageErrorsExitWithTwoAndOneLine) {
  expect_failure({"rendr"}, 2, "did you mean render?");
  expect_failure({"--moed", "uniform"}, 2, "--mode");
  expect_failure({"render"}, 2, "--output");
  expect_failure({"render", "-o", "picture.jpg"}, 2, ".exr");
  expect_failure({"compare", "one.exr"}, 2, "A.exr B.exr");
  expect_failure({"inspect", MAQUETTE_SOURCE_DIR "/README.md"}, 2, "neither a scene");
  expect_failure({"inspect", "notes.txt"}, 1, "does not exist");
  expect_failure({"inspect", MAQUETTE_SOURCE_DIR}, 1, "is a folder");
  expect_failure({"render", "-o", "x.png", "sky.HDR"}, 2, "--env sky.HDR");
  expect_failure({"render", "-o", "x.png", "red.binary"}, 2, "--material NAME=red.binary");
  expect_failure({"render", "-o", "x.png", ""}, 2, "one of its arguments is empty");
  expect_failure({"render", "-o", "x.png", "--material", "Sphere="}, 2, "names no FILE");
  expect_failure({"view", "--frames", "3"}, 2, "add --screenshot");
  expect_failure({"view", "--screenshot", "window.txt"}, 2, "must end in .png");
  expect_failure({"bake", "octre"}, 2, "did you mean octree?");
  expect_failure({"help", "rendr"}, 2, "did you mean render?");
}

TEST(Program, AFileInPlaceOfAFolderIsNamedBeforeTheWork) {
  const TemporaryFolder folder;
  const std::string file = folder.file("notes.txt");
  std::ofstream(file) << "notes";
  expect_failure({"bake", "octree", "builtin:sphere", "-o", file}, 1, "this is a file");
  expect_failure({"report", "builtin:sphere", "-o", file}, 1, "this is a file");
}

TEST(Program, PlayWithoutAPathSaysWhatItNeeds) { expect_failure({"play"}, 2, "PATH.path.json"); }

TEST(Program, ViewWithoutADisplayNamesRender) {
  expect_failure({"view"}, 1, "maquette render");
  expect_failure({}, 1, "no display");
}

TEST(Program, HelpAndVersion) {
  for (const Words& words :
       {Words{"--help"}, Words{"help"}, Words{"help", "render"}, Words{"render", "--help"}, Words{"-h"}}) {
    const ProgramResult result = run_maquette(words);
    EXPECT_EQ(result.exit_code, 0);
    EXPECT_TRUE(contains(result.out, "--output"));
    EXPECT_TRUE(result.error.empty());
  }
  EXPECT_TRUE(run_maquette({"--version"}).out.starts_with("maquette "));
}

TEST(Program, ManualInDocsIsCurrent) {
  const ProgramResult result = run_maquette({"help", "--markdown"});
  EXPECT_EQ(result.out, read_text(MAQUETTE_SOURCE_DIR "/docs/manual.md"))
      << "make it again: maquette help --markdown > docs/manual.md";
}

TEST(Program, VocabularyInDocsIsCurrent) {
  const ProgramResult result = run_maquette({"help", "--vocabulary"});
  EXPECT_EQ(result.out, read_text(MAQUETTE_SOURCE_DIR "/docs/vocabulary.md"))
      << "make it again: maquette help --vocabulary > docs/vocabulary.md";
}

TEST(Program, NamesThatTheSceneLacksExitWithTwoAndLeaveNothing) {
  const TemporaryFolder folder;
  expect_failure(small_render(folder, "a.png", {"--camera", "drivr"}), 2, "no such camera");
  expect_failure(small_render(folder, "a.png", {"--material", "Chrom=builtin:glass"}), 2, "no such material");
  expect_failure(small_render(folder, "a.png", {"--variant", "Night"}), 2, "no such variant");
  expect_failure({"render", "builtin:spere", "-o", folder.file("a.png")}, 2, "sphere");
  EXPECT_TRUE(folder.names().empty());
}

TEST(Program, FilesThatAreNotThereExitWithOneAndLeaveNothing) {
  const TemporaryFolder folder;
  expect_failure({"render", folder.file("none.glb"), "-o", folder.file("a.png")}, 1, "none.glb");
  expect_failure(small_render(folder, "a.png", {"--env", folder.file("none.hdr")}), 1, "none.hdr");
  expect_failure(small_render(folder, "a.png", {"--material", "*=" + folder.file("none.binary")}), 1, "none.binary");
  expect_failure(small_render(folder, "a.png", {"--reference", folder.file("none.exr")}), 1, "none.exr");
  expect_failure({"compare", folder.file("a.exr"), folder.file("b.exr")}, 1, "a.exr");
  expect_failure({"inspect", folder.file("a.glb")}, 1, "a.glb");
  expect_failure({"inspect", folder.file("a.binary")}, 1, "a.binary");
  EXPECT_TRUE(folder.names().empty());
}

TEST(Program, UnwritableOutputIsFoundBeforeTheWork) {
  const TemporaryFolder folder;
  std::filesystem::create_directory(folder.path() / "folder.png");
  expect_failure(small_render(folder, "missing/a.png"), 1, "there is no folder");
  expect_failure(small_render(folder, "folder.png"), 1, "this is a folder");
  expect_failure(small_render(folder, "a.png", {"--stats", folder.file("missing/s.json")}), 1, "there is no folder");
  expect_failure({"render", "-o", "/proc/a.png"}, 1, "cannot be written");
  EXPECT_EQ(folder.names(), Words{"folder.png"});
}

TEST(Program, ViewsThatAModeLacksAreNamed) {
  const TemporaryFolder folder;
  expect_failure(small_render(folder, "a.png", {"--mode", "splitsum", "--view", "samples"}), 1, "takes none");
  expect_failure(small_render(folder, "a.png", {"--mode", "uniform", "--view", "bandwidth"}), 1, "mode bandwidth");
  EXPECT_EQ(run_maquette(small_render(folder, "b.png", {"--mode", "uniform", "--view", "samples"})).exit_code, 0);
  EXPECT_EQ(folder.names(), Words{"b.png"});
}

TEST(Program, NamesMayBeAsLongAsTheSystemTakes) {
  const TemporaryFolder folder;
  expect_failure(small_render(folder, std::string(252, 'a') + ".png"), 1, "this name is too long");
  const std::string longest = std::string(251, 'a') + ".png";
  EXPECT_EQ(run_maquette(small_render(folder, longest)).exit_code, 0);
  EXPECT_EQ(folder.names(), Words{longest});
}

TEST(Program, ADriverBelow45IsNamed) {
  const TemporaryFolder folder;
  for (const char* version : {"3.3", "4.3"}) {
    const std::map<std::string, std::string> environment = {{"MESA_GL_VERSION_OVERRIDE", version}};
    const ProgramResult probe = run_maquette({"doctor"}, environment);
    if (probe.exit_code == 0) GTEST_SKIP() << "this driver does not heed MESA_GL_VERSION_OVERRIDE";
    EXPECT_TRUE(contains(probe.out, "nothing can be drawn"));
    EXPECT_TRUE(contains(probe.out, "\ngraphics: OpenGL")) << probe.out;
    expect_failure(small_render(folder, "a.png"), 1, "4.5", environment);
  }
  EXPECT_TRUE(folder.names().empty());
}

TEST(Program, DoctorAndInspectSpeakJson) {
  const Json doctor = Json::parse(run_maquette({"doctor", "--json"}).out);
  for (const char* key :
       {"maquette", "graphics", "limits", "display", "cache", "libraries", "programs", "what_will_not_work_here"})
    EXPECT_TRUE(doctor.contains(key)) << key;
  const Json sphere = Json::parse(run_maquette({"inspect", "builtin:sphere", "--json"}).out);
  EXPECT_EQ(sphere["kind"], "scene");
  EXPECT_GT(sphere["triangles"].get<int>(), 100);
  EXPECT_EQ(sphere["scene_tree"].size(), sphere["nodes"].get<std::size_t>());
  const Json cockpit = Json::parse(run_maquette({"inspect", "builtin:cockpit", "--json"}).out);
  ASSERT_EQ(cockpit["cameras"].size(), 4u);
  EXPECT_EQ(cockpit["cameras"][0]["name"], "driver");
  EXPECT_EQ(cockpit["cameras"][0]["eye_m"].size(), 3u);
  EXPECT_GT(cockpit["cameras"][0]["fov_deg"].get<double>(), 1.0);
  const std::string told = run_maquette({"inspect", "builtin:cockpit"}).out;
  EXPECT_TRUE(contains(told, "driver: eye m ")) << told;
  EXPECT_TRUE(contains(told, "; 58 deg\n")) << "its angle of view has a unit: " << told;
  EXPECT_TRUE(contains(told, "; a reflector")) << told;
  EXPECT_EQ(sphere["plan"][0]["pass"], "build_shadow_rays");
  EXPECT_EQ(sphere["plan"][1]["pass"], "raster");
  EXPECT_FALSE(sphere["closes_the_eye_in"].get<bool>());
  EXPECT_TRUE(Json::parse(run_maquette({"inspect", "builtin:cornell", "--json"}).out)["closes_the_eye_in"].get<bool>());
  const Json studio = Json::parse(run_maquette({"inspect", "builtin:studio", "--json"}).out);
  EXPECT_EQ(studio["kind"], "environment");
  EXPECT_GT(studio["mean_luminance"].get<double>(), 0.0);
  expect_failure({"inspect", "builtin:corner"}, 2, "did you mean cornell?");
}

}  // namespace
}  // namespace maquette
