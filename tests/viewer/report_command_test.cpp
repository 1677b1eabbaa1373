#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "scenes/scene.h"
#include "test_paths.h"
#include "tests/support/test_scenes.h"
#include "tests/support/waiting.h"
#include "tests/viewer/run_program.h"

namespace maquette {
namespace {

using Json = nlohmann::json;
using Words = std::vector<std::string>;

Words report_words(const std::string& folder, const std::string& budget) {
  return {"report",     "builtin:sphere",
          "--material", "*=builtin:matte-white",
          "--env",      "builtin:studio",
          "--size",     "24x16",
          "--repeats",  "1",
          "--budget",   budget,
          "-o",         folder};
}

/// Starts a report and interrupts it once it has a result. Returns its exit code.
int interrupted_report(const std::string& folder) {
  const pid_t child = fork();
  if (child == 0) {
    Words words = report_words(folder, "600");
    std::vector<char*> arguments = {const_cast<char*>(MAQUETTE_PROGRAM)};
    for (std::string& word : words) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    freopen((folder + "/errors").c_str(), "w", stderr);
    freopen("/dev/null", "w", stdout);
    execv(MAQUETTE_PROGRAM, arguments.data());
    _exit(127);
  }
  int status = 0;
  bool ended = false;
  const bool begun = test::comes_true([&] {
    ended = waitpid(child, &status, WNOHANG) == child;
    return ended || read_text(folder + "/progress.json").find("\"technique\"") != std::string::npos;
  });
  if (ended) return -1;
  kill(child, begun ? SIGINT : SIGKILL);
  waitpid(child, &status, 0);
  return WIFEXITED(status) ? WEXITSTATUS(status) : -1;
}

TEST(ReportCommand, AnInterruptedReportIsKeptAndGoesOn) {
  const TemporaryFolder folder;
  ASSERT_EQ(interrupted_report(folder.path().string()), 1) << read_text(folder.file("errors"));
  EXPECT_NE(read_text(folder.file("errors")).find("the same command continues"), std::string::npos);
  const Json first = Json::parse(read_text(folder.file("report.json")));
  EXPECT_TRUE(first["interrupted"]);
  const std::size_t points = first["points"].size();
  ASSERT_GE(points, 1u);
  EXPECT_NE(read_text(folder.file("report.html")).find("interrupted"), std::string::npos);

  const ProgramResult second = run_maquette(report_words(folder.path().string(), "6"));
  ASSERT_EQ(second.exit_code, 0) << second.error;
  EXPECT_EQ(second.out.find("(0 of this run"), std::string::npos) << second.out;
  const Json json = Json::parse(read_text(folder.file("report.json")));
  EXPECT_FALSE(json["interrupted"]);
  EXPECT_GT(json["points"].size(), points);
  EXPECT_EQ(json["points"][0], first["points"][0]);  // reused, not measured again
  EXPECT_FALSE(json["machine"]["processor"].get<std::string>().empty());
  EXPECT_FALSE(json["left_out"].empty());
  for (const Json& reference : json["references"]) EXPECT_GT(reference["samples"], 0);
  const std::string csv = read_text(folder.file("report.csv"));
  EXPECT_EQ(static_cast<std::size_t>(std::count(csv.begin(), csv.end(), '\n')), json["points"].size() + 1);
  for (const std::string& name : folder.names()) EXPECT_EQ(name.find(".part"), std::string::npos) << name;

  // No space on the disk: one line, and the old file is unchanged.
  const ProgramResult full =
      run_in_folder(".", "bash",
                    {"-c", "trap '' XFSZ; ulimit -f 2; exec \"$@\"", "bash", MAQUETTE_PROGRAM, "report",
                     "builtin:sphere", "--material", "*=builtin:matte-white", "--env", "builtin:studio", "--size",
                     "24x16", "--repeats", "1", "--budget", "6", "-o", folder.path().string()});
  EXPECT_EQ(full.exit_code, 1);
  EXPECT_EQ(std::count(full.error.begin(), full.error.end(), '\n') > 0, true);
  EXPECT_NE(full.error.find("maquette: "), std::string::npos) << full.error;
  EXPECT_EQ(Json::parse(read_text(folder.file("report.json")))["points"][0], first["points"][0]);
  EXPECT_GE(Json::parse(read_text(folder.file("progress.json")))["points"].size(), points);
}

TEST(ReportCommand, WhatCannotBeReflectedIsLeftOut) {
  const TemporaryFolder folder;
  Scene scene = test::sphere_of(test::white_lambert());
  Material glass = test::clear_pane();
  glass.name = "glass";
  scene.materials.push_back(glass);
  const int material = static_cast<int>(scene.materials.size()) - 1;
  for (int i = 0; i < 17; ++i)  // one more than are drawn at once
    test::add(&scene,
              test::make_grid({-1, -1, 2.0f + 0.01f * static_cast<float>(i)}, {2, 0, 0}, {0, 2, 0}, 1, material),
              "pane " + std::to_string(i));
  save_glb(folder.file("panes.glb"), scene);
  Words words = report_words(folder.file("report"), "8");
  words[1] = folder.file("panes.glb");
  words.erase(words.begin() + 2, words.begin() + 4);  // its materials stay
  const ProgramResult result = run_maquette(words);
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const Json json = Json::parse(read_text(folder.file("report/report.json")));
  EXPECT_FALSE(json["points"].empty());
  EXPECT_NE(json["not_measured"].dump().find("17 reflectors are more than"), std::string::npos) << json["not_measured"];
}

TEST(ReportCommand, BadFoldersAreNamedBeforeAnyWork) {
  const TemporaryFolder folder;
  std::ofstream(folder.file("file")) << "x";
  const ProgramResult file = run_maquette(report_words(folder.file("file"), "6"));
  EXPECT_EQ(file.exit_code, 1);
  EXPECT_NE(file.error.find("this is a file"), std::string::npos) << file.error;
  const ProgramResult nowhere = run_maquette(report_words("/proc/no-report-here", "6"));
  EXPECT_EQ(nowhere.exit_code, 1);
  EXPECT_NE(nowhere.error.find("cannot be made"), std::string::npos) << nowhere.error;
  const ProgramResult none = run_maquette({"report", "builtin:sphere"});
  EXPECT_EQ(none.exit_code, 2);
  EXPECT_NE(none.error.find("--output FOLDER"), std::string::npos) << none.error;
}

}  // namespace
}  // namespace maquette
