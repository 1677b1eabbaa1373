// What commands say of the bakes that a review names, through the real program.
#include <gtest/gtest.h>

#include <filesystem>

#include "review/review.h"
#include "tests/support/test_scenes.h"
#include "tests/support/text.h"
#include "tests/viewer/run_program.h"
#include "viewer/session.h"

namespace maquette {
namespace {

namespace fs = std::filesystem;

using test::contains;

class ReviewBakesCommand : public testing::Test {
 protected:
  void SetUp() override {
    write_room(0.0f);
    review_.scene = folder_.file("room.glb");
    Look& look = review_.look;
    look.edits.environment = "builtin:studio";
    look.camera.eye = {0.3f, 0.1f, 0.2f};
    look.camera.target = {-1.0f, -0.6f, -0.7f};
    look.mode = "uniform";
    look.settings.set("uniform.samples", 4);
    look.settings.set("shading.visibility", std::string("baked"));
    Look bare = look;
    bare.name = "bare";
    bare.settings.set("shading.visibility", std::string("none"));
    CameraPath path;
    path.name = "around";
    for (int i = 0; i < 2; ++i) {
      PathKey key;
      key.camera = look.camera;
      key.camera.eye.x -= 0.1f * static_cast<float>(i);
      key.duration_s = 0.1;
      path.keys.push_back(key);
    }
    review_.looks = {bare};
    review_.paths = {path};
    file_ = folder_.file("a.maquette.json");
    save_review(file_, review_);
  }
  /// A room without a roof; `moved`: what one corner is away from its place, m.
  void write_room(float moved) {
    Scene scene = test::box_scene(5, 3, test::matte(glm::vec3(0.4f)));
    scene.meshes[1].primitives[0].positions[0].x += moved;
    save_glb(folder_.file("room.glb"), scene);
  }
  ProgramResult run(std::vector<std::string> arguments, const std::string& cache = "cache") {
    arguments.insert(arguments.end(), {"--size", "48x27"});
    return run_maquette(arguments, {{"MAQUETTE_CACHE", folder_.file(cache)}});
  }
  ProgramResult render(const std::vector<std::string>& more = {}, const std::string& cache = "cache") {
    std::vector<std::string> arguments = {"render", file_, "-o", folder_.file("a.exr")};
    arguments.insert(arguments.end(), more.begin(), more.end());
    const ProgramResult result = run(arguments, cache);
    EXPECT_EQ(result.exit_code, 0) << result.error;
    return result;
  }
  /// Bakes, and names in the review what the cache then has.
  void save_with_keys() {
    render();
    BakeKeys keys;
    for (const std::string& name : fs_names(folder_.file("cache")))
      for (const std::string bake : {"visibility", "indirect"})
        if (name.starts_with(bake)) keys[bake] = name.substr(name.size() - 20, 16);
    ASSERT_EQ(keys.size(), 2u);
    save_review(file_, review_, list_bakes({{"", keys}}));
  }
  static std::vector<std::string> fs_names(const std::string& folder) {
    std::vector<std::string> names;
    for (const fs::directory_entry& entry : fs::directory_iterator(folder))
      names.push_back(entry.path().filename().string());
    return names;
  }

  TemporaryFolder folder_;
  Review review_;
  std::string file_;
};

TEST_F(ReviewBakesCommand, SayWhatIsToBeMadeWhereTheCacheIsAnother) {
  save_with_keys();
  EXPECT_EQ(render().error, "") << "all is there";
  EXPECT_EQ(render({"--look", "bare"}, "other").error, "") << "the look draws with no bake";
  const std::string error = render({}, "other").error;
  const std::string begin = "warning: " + file_ + ": bake ";
  EXPECT_TRUE(contains(error, begin + "visibility of the state at hand is not in the cache: to be made; it changes "
                                      "shadows of the sky, which come with indirect light\n"))
      << error;
  EXPECT_TRUE(contains(error, begin + "indirect of the state at hand is not in the cache: to be made; it changes "))
      << error;
  EXPECT_EQ(render({}, "other").error, "") << "now it has them";
}

TEST_F(ReviewBakesCommand, SayWhichAreMadeAnewForAnotherScene) {
  save_with_keys();
  write_room(0.2f);
  const std::string error = render().error;
  for (const std::string bake : {"visibility", "indirect"})
    EXPECT_TRUE(contains(error, "bake " + bake +
                                    " of the state at hand: the scene is not as it was when the review was "
                                    "saved; it is made anew; it changes "))
        << error;
  EXPECT_FALSE(contains(error, "to be made")) << error;
  EXPECT_TRUE(
      contains(render().error, "the scene is not as it was when the review was saved; what it needs now is there"));
  write_room(0.0f);
  EXPECT_EQ(render({"--env-rotation", "40"}).error, "") << "what options change is not what was saved";
}

TEST_F(ReviewBakesCommand, PlayReportAndInspectSayItToo) {
  save_with_keys();
  const std::vector<std::string> play = {"play", file_, "--path", "around", "--fps", "10", "--format", "exr", "-o"};
  auto to = [&](const std::string& folder) {
    std::vector<std::string> arguments = play;
    arguments.push_back(folder_.file(folder));
    return arguments;
  };
  const ProgramResult here = run(to("one"));
  EXPECT_EQ(here.exit_code, 0) << here.error;
  EXPECT_FALSE(contains(here.error, "bake ")) << here.error;
  const ProgramResult elsewhere = run(to("two"), "other");
  EXPECT_EQ(elsewhere.exit_code, 0) << elsewhere.error;
  EXPECT_TRUE(contains(elsewhere.error, "bake visibility of the state at hand is not in the cache")) << elsewhere.error;

  const auto report = [&](const std::string& cache) {
    const ProgramResult result =
        run({"report", file_, "-o", folder_.file("report-" + cache), "--budget", "5", "--repeats", "1"}, cache);
    EXPECT_EQ(result.exit_code, 0) << result.error;
    return result.error;
  };
  EXPECT_FALSE(contains(report("cache"), "bake visibility"));
  const std::string third = report("third");
  EXPECT_TRUE(contains(third, "bake visibility of the state at hand is not in the cache")) << third;

  const auto inspect = [&](const std::string& cache) {
    return run_maquette({"inspect", file_}, {{"MAQUETTE_CACHE", folder_.file(cache)}}).out;
  };
  EXPECT_TRUE(contains(inspect("cache"), "; kept")) << inspect("cache");
  EXPECT_FALSE(contains(inspect("cache"), "to be made")) << inspect("cache");
  EXPECT_TRUE(contains(inspect("fourth"), "; to be made")) << inspect("fourth");
}

}  // namespace
}  // namespace maquette
