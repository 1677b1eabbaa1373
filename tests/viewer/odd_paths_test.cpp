// Names of files that are no UTF-8, in every command that writes JSON.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>

#include "review/open_review.h"
#include "review/review.h"
#include "scenes/builtin.h"
#include "scenes/files.h"
#include "scenes/scene.h"
#include "tests/viewer/run_program.h"
#include "viewer/session.h"
#include "viewer/window_memory.h"

namespace maquette {
namespace {

class OddPaths : public testing::Test {
 protected:
  void SetUp() override {
    odd_ = folder_.file("caf\xe9");
    std::filesystem::create_directories(odd_);
    scene_ = odd_ + "/\xfftable.glb";
    save_glb(scene_, build_builtin_scene("plate"));
    review_.scene = scene_;
    const Scene scene = load_scene(scene_);
    review_.look.camera = camera_by_name(scene, camera_names(scene).front());
    review_.look.settings.set("shading.visibility", std::string("none"));
    file_ = odd_ + "/a\xff.maquette.json";
    save_review(file_, review_);
  }
  void expect_done(std::vector<std::string> arguments) {
    const ProgramResult result = run_maquette(arguments);
    EXPECT_EQ(result.exit_code, 0) << arguments[0] << ": " << result.error;
    EXPECT_EQ(result.error.find("json"), std::string::npos) << result.error;
  }

  TemporaryFolder folder_;
  std::string odd_, scene_, file_;
  Review review_;
};

TEST_F(OddPaths, ReviewsKeepThem) {
  const Review again = load_review(file_);
  EXPECT_EQ(again.scene, scene_);
  {
    OpenReview open(file_);
    Review now = open.review();
    now.look.edits.materials["a"] = odd_ + "/\xe9.binary";
    open.observe(now, false);
  }
  OpenReview open(file_);  // from its journal
  EXPECT_EQ(open.review().look.edits.materials.at("a"), odd_ + "/\xe9.binary");
}

TEST_F(OddPaths, CommandsTakeAndNameThem) {
  const std::vector<std::string> small = {"--size", "32x18",           "--samples", "2",
                                          "--mode", "splitsum",        "--set",     "shading.visibility=none",
                                          "--set",  "ground.kind=none"};
  const auto with = [&](std::vector<std::string> words) {
    words.insert(words.end(), small.begin(), small.end());
    return words;
  };
  expect_done(with({"render", scene_, "-o", odd_ + "/a\xfe.png", "--stats", odd_ + "/a\xfe.json"}));
  expect_done(with({"render", file_, "-o", odd_ + "/b\xfe.exr"}));
  expect_done({"inspect", scene_});
  expect_done({"inspect", file_});
  EXPECT_TRUE(std::filesystem::exists(odd_ + "/a\xfe.json"));
}

TEST_F(OddPaths, TheWindowRemembersThem) {
  ::setenv("XDG_STATE_HOME", folder_.file("home").c_str(), 1);
  WindowMemory memory;
  memory.recent = {scene_};
  save_window_memory(memory);
  EXPECT_EQ(load_window_memory().recent, memory.recent);
  ::unsetenv("XDG_STATE_HOME");
}

}  // namespace
}  // namespace maquette
