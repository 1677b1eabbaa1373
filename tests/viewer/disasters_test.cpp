// Commands that are killed, and disks that are full: what was there before is whole, what is said to be done is whole,
// nothing temporary remains after the next run. A hundred of each command:
//
//   MAQUETTE_KILLS=100 build/tests/test_viewer --gtest_filter='Disasters.*'
#include <gtest/gtest.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <random>
#include <thread>

#include "review/review.h"
#include "scenes/bake_file.h"
#include "scenes/image_io.h"
#include "scenes/scene.h"
#include "test_paths.h"
#include "tests/support/test_scenes.h"
#include "tests/viewer/run_program.h"

namespace maquette {
namespace {

namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using Words = std::vector<std::string>;

/// A command, and the folder below the working one that has all that it writes.
struct Writer {
  std::string name;
  Words words;
};

class Disasters : public testing::Test {
 protected:
  void SetUp() override {
    Scene scene;
    scene.materials = {test::matte(glm::vec3(0.5f))};
    test::add(&scene, test::make_grid({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 2, 0), "floor");
    test::add(&scene, test::make_grid({-1, 0, 0}, {1, 0, 0}, {0, 1, 0}, 2, 0), "wall");
    save_glb(at("a.glb"), scene);
    Review review;
    review.scene = at("a.glb");
    review.look.camera = {{0.0f, 1.0f, 3.0f}, {0.0f, 0.3f, 0.0f}};
    CameraPath path;
    path.name = "way";
    path.keys.resize(2);
    path.keys[0].camera = path.keys[1].camera = review.look.camera;
    path.keys[1].camera.eye.x += 1.0f;
    path.keys[0].duration_s = 0.5;
    review.paths = {path};
    save_review(at("r.maquette.json"), review);
  }
  std::string at(const std::string& name) const { return folder_.file(name); }

  /// All that writes; `out`: the folder for it.
  std::vector<Writer> writers(const std::string& out) const {
    const std::string scene = at("a.glb"), review = at("r.maquette.json");
    const auto small = [](Words words) {
      words.insert(words.end(), {"--size", "48x32", "--samples", "2", "--set", "ground.kind=none"});
      return words;
    };
    return {{"png", small({"render", scene, "-o", out + "/a.png", "--stats", out + "/a.json"})},
            {"exr", small({"render", scene, "-o", out + "/b.exr", "--time", "0.3"})},
            {"look", small({"render", review, "-o", out + "/c.exr"})},
            {"play", small({"play", review, "--path", "way", "--fps", "10", "--format", "exr", "-o", out + "/frames"})},
            {"report",
             {"report", scene, "--budget", "5", "--size", "48x32", "--set", "ground.kind=none", "-o", out + "/report"}},
            {"measure",
             {"measure", "builtin:cockpit", "--mode", "reference", "--size", "32x18", "--samples", "1", "-o",
              out + "/m.json", "--layers", out + "/m.exr"}},
            {"octree", {"bake", "octree", scene, "--set", "octree.depth=5", "-o", out + "/octree"}},
            {"slf",
             {"bake", "slf", scene, "--set", "slf.texels=48", "--set", "slf.directions=8", "--set", "slf.paths=2",
              "-o", out + "/slf"}},
            {"prt", {"bake", "prt", scene, "--set", "prt.rays=1", "--set", "prt.faces=4", "-o", out + "/prt"}}};
  }

  /// Every file of ours below a folder is one that is read again; those of another kind are left to their writers.
  static void expect_whole(const std::string& folder, const std::string& what) {
    for (const auto& entry : fs::recursive_directory_iterator(folder)) {
      if (!entry.is_regular_file()) continue;
      const std::string file = entry.path().string(), name = entry.path().filename().string();
      if (name.front() == '.') continue;  // in work: its place is judged
      EXPECT_GT(entry.file_size(), 0u) << what << ": " << file;
      if (entry.path().extension() != ".exr") continue;
      const bool bake = file.find("/octree/") != std::string::npos || file.find("-slf/") != std::string::npos ||
                        file.find("-prt/") != std::string::npos;
      if (bake)
        EXPECT_NO_THROW(load_bake_file(file)) << what << ": " << file;
      else
        EXPECT_NO_THROW(load_hdr_image(file)) << what << ": " << file;
    }
  }
  static void expect_nothing_temporary(const std::string& folder, const std::string& what) {
    for (const auto& entry : fs::recursive_directory_iterator(folder))
      EXPECT_NE(entry.path().filename().string().front(), '.') << what << ": " << entry.path();
  }

  /// Runs the program and kills it after a while, if it still runs.
  void run_and_kill(const Words& words, Clock::duration after) const {
    const pid_t child = ::fork();
    if (child == 0) {
      ::setenv("MAQUETTE_CACHE", at("cache").c_str(), 1);
      if (!std::freopen("/dev/null", "w", stdout) || !std::freopen("/dev/null", "w", stderr)) ::_exit(4);
      std::vector<char*> arguments{const_cast<char*>(MAQUETTE_PROGRAM)};
      for (const std::string& word : words) arguments.push_back(const_cast<char*>(word.c_str()));
      arguments.push_back(nullptr);
      ::execv(MAQUETTE_PROGRAM, arguments.data());
      ::_exit(127);
    }
    std::this_thread::sleep_for(after);
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
  }
  ProgramResult run(const Words& words) const { return run_maquette(words, {{"MAQUETTE_CACHE", at("cache")}}); }

  TemporaryFolder folder_;
};

TEST_F(Disasters, KilledCommandsLeaveWhatIsWhole) {
  const char* const asked = std::getenv("MAQUETTE_KILLS");
  const int kills = asked ? std::atoi(asked) : 3;
  const std::string out = at("out");
  fs::create_directories(out);
  const std::vector<Writer> all = writers(out);
  std::map<std::string, Clock::duration> takes;
  std::mt19937 random(11);
  for (int i = 0; i < kills; ++i) {
    const Writer& writer = all[static_cast<std::size_t>(asked ? i : 3 * i) % all.size()];
    const std::string what = writer.name + ", kill " + std::to_string(i);
    if (!takes.contains(writer.name)) {
      const Clock::time_point begin = Clock::now();
      const ProgramResult result = run(writer.words);
      ASSERT_EQ(result.exit_code, 0) << what << ": " << result.error;
      takes[writer.name] = Clock::now() - begin;
      expect_nothing_temporary(out, what);
    }
    // Over what is there, or into nothing.
    if (i / static_cast<int>(all.size()) % 2 == 1) {
      fs::remove_all(out);
      fs::create_directories(out);
    }
    run_and_kill(writer.words, takes[writer.name] * static_cast<int>(random() % 1000) / 1000);
    expect_whole(out, what);
    const ProgramResult again = run(writer.words);
    EXPECT_EQ(again.exit_code, 0) << what << ": " << again.error;
    expect_whole(out, what + ", again");
    expect_nothing_temporary(out, what + ", again");
  }
}

/// Needs a file system of 2 MB that a user may mount.
TEST_F(Disasters, AFullDiskLosesNothing) {
  const std::string disk = at("disk");
  fs::create_directories(disk);
  // Each line runs in a mount namespace of its own: the old files, a filler that leaves so many bytes, the command.
  const auto on_disk = [&](const std::string& filler_kb, const Words& words) {
    std::string command = "mount -t tmpfs -o size=2m none '" + disk + "' && cp -r '" + at("old") + "/.' '" + disk +
                          "' && { [ " + filler_kb + " = 0 ] || head -c " + filler_kb + "k /dev/zero > '" + disk +
                          "/filler' 2> /dev/null; :; }; MAQUETTE_CACHE='" + at("cache") + "' '" +
                          std::string(MAQUETTE_PROGRAM) + "'";
    for (const std::string& word : words) command += " '" + word + "'";
    command += "; code=$?; rm -f '" + disk + "/filler'; rm -rf '" + at("new") + "'; cp -r '" + disk + "' '" +
               at("new") + "'; exit $code";
    return run_in_folder(".", "/usr/bin/unshare", {"--map-root-user", "--mount", "sh", "-c", command});
  };
  fs::create_directories(at("old"));
  if (run_in_folder(".", "/usr/bin/unshare",
                    {"--map-root-user", "--mount", "sh", "-c", "mount -t tmpfs -o size=2m none '" + disk + "'"})
          .exit_code != 0)
    GTEST_SKIP() << "no file system of 2 MB can be mounted here";
  const bool all_sizes = std::getenv("MAQUETTE_KILLS") != nullptr;
  for (const Writer& writer : writers(disk)) {
    if (!all_sizes && writer.name != "png" && writer.name != "octree" && writer.name != "play") continue;
    fs::remove_all(at("old"));
    fs::create_directories(at("old"));
    const ProgramResult free = on_disk("0", writer.words);
    ASSERT_EQ(free.exit_code, 0) << writer.name << ": " << free.error;
    expect_nothing_temporary(at("new"), writer.name);
    fs::remove_all(at("old"));
    fs::copy(at("new"), at("old"), fs::copy_options::recursive);
    for (const char* filler : {"2048", "2000", "1900", "1500"}) {
      if (!all_sizes && std::string(filler) != "2048") continue;
      const std::string what = writer.name + ", filled with " + filler + " kB";
      const ProgramResult full = on_disk(filler, writer.words);
      EXPECT_TRUE(full.exit_code == 0 || full.exit_code == 1) << what << ": " << full.error;
      if (full.exit_code == 1) {
        EXPECT_FALSE(full.error.empty()) << what;
      }
      if (writer.name == "png" && std::string(filler) == "2048") {
        EXPECT_EQ(full.exit_code, 1) << what << ": it cannot be done";
      }
      expect_whole(at("new"), what);
      expect_nothing_temporary(at("new"), what);
    }
  }
}

}  // namespace
}  // namespace maquette
