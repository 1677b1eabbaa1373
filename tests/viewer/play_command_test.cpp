// Looks and camera paths through the real program.
#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>

#include "review/review.h"
#include "scenes/image_io.h"
#include "tests/support/text.h"
#include "tests/viewer/run_program.h"
#include "viewer/session.h"

namespace maquette {
namespace {

namespace fs = std::filesystem;

using test::contains;

class Play : public testing::Test {
 protected:
  void SetUp() override {
    review_.scene = "builtin:plate";
    const Scene scene = load_scene(review_.scene);
    Look& look = review_.look;
    look.camera = camera_by_name(scene, camera_names(scene).front());
    look.settings.set("shading.visibility", std::string("none"));
    Look red = look;
    red.name = "red";
    red.edits.materials[scene.materials.front().name] = "builtin:paint-pearl-white";
    red.camera.eye.x += 0.3f;
    review_.looks = {red};
    path_.name = "around";
    for (int i = 0; i < 3; ++i) {
      PathKey key;
      key.camera = look.camera;
      key.camera.eye.x += 0.2f * static_cast<float>(i);
      key.duration_s = 0.2;
      path_.keys.push_back(key);
    }
    path_.keys[2].look = "red";
    review_.paths = {path_};
    file_ = folder_.file("a.maquette.json");
    save_review(file_, review_);
  }
  ProgramResult run(std::vector<std::string> arguments, const std::map<std::string, std::string>& environment = {}) {
    arguments.insert(arguments.end(), {"--size", "48x27", "--samples", "4"});
    return run_maquette(arguments, environment);
  }
  ProgramResult play(const std::string& output, const std::vector<std::string>& more = {},
                     const std::map<std::string, std::string>& environment = {}) {
    std::vector<std::string> arguments = {"play", file_, "--path", "around", "--fps", "10", "-o", folder_.file(output)};
    arguments.insert(arguments.end(), more.begin(), more.end());
    return run(arguments, environment);
  }
  void expect_same_pixels(const std::string& a, const std::string& b) {
    const Image first = load_hdr_image(folder_.file(a)), second = load_hdr_image(folder_.file(b));
    ASSERT_EQ(first.data.size(), second.data.size());
    EXPECT_EQ(std::memcmp(first.data.data(), second.data.data(), first.data.size() * sizeof(float)), 0)
        << a << " " << b;
  }
  std::string replaced_path(const std::string& ffmpeg) {
    fs::create_directories(folder_.file("bin"));
    std::ofstream(folder_.file("bin/ffmpeg")) << ffmpeg;
    fs::permissions(folder_.file("bin/ffmpeg"), fs::perms::owner_all);
    return folder_.file("bin") + ":/usr/bin:/bin";
  }

  TemporaryFolder folder_;
  Review review_;
  CameraPath path_;
  std::string file_;
};

/// Stands for ffmpeg: the video is what it is sent, and lists five frames.
const std::string kTakesAll =
    "#!/bin/sh\nfor last; do :; done\nif [ \"$last\" = - ]; then seq 5; else cat > \"$last\"; fi\n";

TEST_F(Play, FramesAreTheSameResumedAndRendered) {
  const ProgramResult whole = play("whole", {"--format", "exr"});
  ASSERT_EQ(whole.exit_code, 0) << whole.error;
  EXPECT_TRUE(contains(whole.out, "5 frames of 48x27, 5 of them drawn now")) << whole.out;
  fs::copy(folder_.file("whole"), folder_.file("part"));
  for (const char* frame : {"part/frame-00001.exr", "part/frame-00004.exr"}) fs::remove(folder_.file(frame));
  const ProgramResult rest = play("part", {"--format", "exr"});
  EXPECT_TRUE(contains(rest.out, "2 of them drawn now")) << rest.out << rest.error;
  for (int i = 0; i < 5; ++i) {
    const std::string name = "/frame-0000" + std::to_string(i) + ".exr";
    expect_same_pixels("whole" + name, "part" + name);
  }
  // What `render` draws of the same state.
  Review review = review_;
  for (int i : {1, 4}) {
    Look look = i == 4 ? review_.looks[0] : review_.look;
    look.name = "frame " + std::to_string(i);
    look.camera = path_at(path_, 0.1 * i).camera;
    review.looks.push_back(look);
  }
  save_review(folder_.file("b.maquette.json"), review);
  for (int i : {1, 4}) {
    const std::string name = std::to_string(i);
    const ProgramResult one = run({"render", folder_.file("b.maquette.json"), "--look", "frame " + name, "-o",
                                   folder_.file("look" + name + ".exr"), "--stats", folder_.file("s.json")});
    ASSERT_EQ(one.exit_code, 0) << one.error;
    expect_same_pixels("look" + name + ".exr", "whole/frame-0000" + name + ".exr");
  }
}

TEST_F(Play, APathWhoseFirstKeyNamesALookIsTheSameFromAnyState) {
  const ProgramResult before = play("loose", {"--format", "exr"});
  EXPECT_TRUE(contains(before.error, "its first key names no look")) << before.error;
  review_.paths[0].keys[0].look = "red";
  save_review(file_, review_);
  const ProgramResult one = play("one", {"--format", "exr"});
  ASSERT_EQ(one.exit_code, 0) << one.error;
  EXPECT_FALSE(contains(one.error, "names no look")) << one.error;
  review_.look.edits.env_scale = 3.0f;
  review_.look.mode = "splitsum";
  save_review(file_, review_);
  ASSERT_EQ(play("two", {"--format", "exr"}).exit_code, 0);
  expect_same_pixels("one/frame-00000.exr", "two/frame-00000.exr");
  // What the command changes holds in the looks of keys too.
  ASSERT_EQ(play("bright", {"--format", "exr", "--env-scale", "2"}).exit_code, 0);
  const Image plain = load_hdr_image(folder_.file("one/frame-00000.exr")),
              bright = load_hdr_image(folder_.file("bright/frame-00000.exr"));
  for (const std::size_t i : {std::size_t{0}, plain.data.size() / 8 * 4})
    EXPECT_NEAR(bright.data[i], 2.0f * plain.data[i], 1e-3f * plain.data[i]);
}

TEST_F(Play, FramesThatCannotBeReadAreDrawnAgain) {
  ASSERT_EQ(play("frames").exit_code, 0);
  const std::string empty = folder_.file("frames/frame-00001.png"), cut = folder_.file("frames/frame-00003.png");
  const std::string whole = read_text(cut);
  fs::resize_file(empty, 0);
  fs::resize_file(cut, whole.size() / 2);
  const ProgramResult again = play("frames");
  EXPECT_TRUE(contains(again.out, "2 of them drawn now")) << again.out << again.error;
  EXPECT_EQ(read_text(cut), whole);
  EXPECT_GT(fs::file_size(empty), 0u);
}

TEST_F(Play, WhatALookSaysOfPartsThatAreGoneIsNamed) {
  review_.look.edits.hidden_nodes = {"/gone"};
  review_.look.edits.turns = {{"/turned", {0.0f, 1.0f, 0.0f}, 5.0f}};
  review_.look.edits.part_modes = {{"/shaded", "splitsum"}};
  review_.look.edits.animation = {"wave", 0.5};
  save_review(file_, review_);
  const ProgramResult result = run({"render", file_, "-o", folder_.file("a.exr")});
  for (const char* name : {"/gone", "/turned", "/shaded", "no animation \"wave\""})
    EXPECT_TRUE(contains(result.error, name)) << name << ": " << result.error;
}

TEST_F(Play, SourcesOfTheNetAreRefusedByName) {
  std::string text = read_text(file_);
  const std::string scene = "\"builtin:plate\"";
  text.replace(text.find(scene), scene.size(), "\"http://car/a.glb\"");
  std::ofstream(file_) << text;
  const ProgramResult result = run({"render", file_, "-o", folder_.file("a.exr")});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(contains(result.error, "\"http://car/a.glb\" is not read")) << result.error;
}

TEST_F(Play, AFolderOfAnotherPathIsRefused) {
  ASSERT_EQ(play("frames").exit_code, 0);
  review_.paths[0].keys[1].camera.eye.y += 0.1f;
  save_review(file_, review_);
  const ProgramResult other = play("frames");
  EXPECT_EQ(other.exit_code, 1);
  EXPECT_TRUE(contains(other.error, "frames of another path, look, size or scene; choose another folder"))
      << other.error;
}

TEST_F(Play, PathFilesNeedNoReview) {
  CameraPath plain = path_;
  plain.keys[2].look.reset();
  save_path(folder_.file("a.path.json"), plain);
  const ProgramResult ok = run({"play", folder_.file("a.path.json"), "builtin:plate", "--fps", "5", "--set",
                                "shading.visibility=none", "-o", folder_.file("frames")});
  EXPECT_EQ(ok.exit_code, 0) << ok.error;
  EXPECT_TRUE(fs::exists(folder_.file("frames/frame-00002.png")));
  save_path(folder_.file("b.path.json"), path_);
  const ProgramResult look = run({"play", folder_.file("b.path.json"), "builtin:plate", "-o", folder_.file("other")});
  EXPECT_TRUE(contains(look.error, "there is no review")) << look.error;
}

/// A frame that moves what the frame before showed is the frame that is drawn alone.
TEST_F(Play, AnimationsOfTheSceneArePlayedBitForBit) {
  Scene scene = load_scene("builtin:plate");
  Animation slide;
  slide.name = "slide";
  slide.duration_s = 0.4;
  for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
    if (scene.nodes[i].mesh < 0) continue;
    AnimatedNode node;
    node.node = static_cast<int>(i);
    node.tracks[AnimatedNode::translation] = {
        AnimationTrack::Interpolation::linear, {0.0f, 0.4f}, {glm::vec4(0.0f), glm::vec4(0.4f, 0.1f, 0.0f, 0.0f)}};
    slide.nodes.push_back(node);
    break;
  }
  scene.animations = {slide};
  save_glb(folder_.file("slide.glb"), scene);
  const std::vector<std::string> call = {"play",        folder_.file("slide.glb"),
                                         "--animation", "slide",
                                         "--fps",       "5",
                                         "--format",    "exr",
                                         "--set",       "ground.kind=none",
                                         "-o",          folder_.file("frames")};
  const ProgramResult whole = run(call);
  ASSERT_EQ(whole.exit_code, 0) << whole.error;
  EXPECT_TRUE(contains(whole.out, "3 frames of 48x27")) << whole.out;
  fs::rename(folder_.file("frames/frame-00001.exr"), folder_.file("kept.exr"));
  EXPECT_TRUE(contains(run(call).out, "1 of them drawn now"));
  expect_same_pixels("kept.exr", "frames/frame-00001.exr");
  const Image first = load_hdr_image(folder_.file("frames/frame-00000.exr")),
              last = load_hdr_image(folder_.file("frames/frame-00002.exr"));
  EXPECT_NE(first.data, last.data) << "it moves";
  // What `render` draws of a look at that moment.
  Review review;
  review.scene = folder_.file("slide.glb");
  review.look.camera = camera_of_options(scene, SceneOptions());
  review.look.edits.animation = {"slide", 0.2};
  const std::string file = folder_.file("slide.maquette.json");
  save_review(file, review);
  const ProgramResult one = run({"render", file, "-o", folder_.file("look.exr")});
  ASSERT_EQ(one.exit_code, 0) << one.error;
  expect_same_pixels("look.exr", "kept.exr");
  const ProgramResult unknown =
      run({"play", folder_.file("slide.glb"), "--animation", "slid", "-o", folder_.file("x")});
  EXPECT_TRUE(contains(unknown.error, "no such animation; did you mean slide?")) << unknown.error;
}

TEST_F(Play, BadCallsAreNamed) {
  const auto error = [&](std::vector<std::string> arguments) {
    const ProgramResult result = run_maquette(arguments);
    EXPECT_NE(result.exit_code, 0);
    EXPECT_EQ(std::count(result.error.begin(), result.error.end(), '\n'), 1) << result.error;
    return result.error;
  };
  const std::string out = folder_.file("out");
  EXPECT_TRUE(contains(error({"play", file_, "-o", out}), "add --path NAME"));
  EXPECT_TRUE(contains(error({"play", file_, "--path", "arund", "-o", out}), "did you mean around?"));
  EXPECT_TRUE(contains(error({"play", file_, "--path", "around"}), "add --output"));
  EXPECT_TRUE(contains(error({"play", file_, "--path", "around", "-o", out, "--time", "3"}), "--time"));
  EXPECT_TRUE(contains(error({"play", file_, "--path", "around", "-o", out + ".avi"}), "neither a folder nor a video"));
  EXPECT_TRUE(contains(error({"render", file_, "--look", "rd", "-o", out + ".exr"}), "did you mean red?"));
  EXPECT_TRUE(contains(error({"render", file_, "--time", "3", "-o", out + ".exr"}), "settled frame"));
  EXPECT_TRUE(contains(error({"render", "--look", "red", "-o", out + ".exr"}), "there is no review"));
  EXPECT_TRUE(contains(error({"render", file_, "-o", file_ + ".exr", "--env", "nothing.hdr"}), "nothing.hdr"));
  CameraPath single = path_;
  single.keys.resize(1);
  save_path(folder_.file("one.path.json"), single);
  EXPECT_TRUE(contains(error({"play", folder_.file("one.path.json"), "-o", out}), "one key only"));
  CameraPath at_once = path_;
  for (PathKey& key : at_once.keys) key.duration_s = key.delay_s = 0.0;
  save_path(folder_.file("none.path.json"), at_once);
  EXPECT_TRUE(contains(error({"play", folder_.file("none.path.json"), "-o", out}), "the path has no duration"));
  review_.paths[0] = at_once;
  save_review(file_, review_);
  EXPECT_TRUE(contains(error({"play", file_, "--path", at_once.name, "-o", out}), "the path has no duration"));
  review_.look.edits.environment = folder_.file("gone.hdr");
  review_.look.edits.materials["x"] = folder_.file("gone.binary");
  save_review(file_, review_);
  const std::string missing = error({"render", file_, "-o", out + ".exr"});
  EXPECT_TRUE(contains(missing, "gone.hdr") && contains(missing, "gone.binary")) << missing;
}

TEST_F(Play, WithoutFfmpegItSaysWhatToInstall) {
  const ProgramResult result = play("a.mp4", {}, {{"PATH", "/nowhere"}});
  EXPECT_EQ(result.exit_code, 1);
  EXPECT_TRUE(contains(result.error, "apt install ffmpeg")) << result.error;
  EXPECT_FALSE(fs::exists(folder_.file("a.mp4.frames"))) << "it says so before any work";
}

TEST_F(Play, AVideoThatFailsKeepsItsFrames) {
  const std::string broken =
      replaced_path("#!/bin/sh\nhead -c 100 > /dev/null\necho 'av_write: No space left on device' >&2\nexit 1\n");
  const ProgramResult failed = play("a.mp4", {}, {{"PATH", broken}});
  EXPECT_EQ(failed.exit_code, 1);
  EXPECT_TRUE(contains(failed.error, "No space left on device")) << failed.error;
  EXPECT_FALSE(fs::exists(folder_.file("a.mp4")));
  ASSERT_TRUE(fs::exists(folder_.file("a.mp4.frames/frame-00000.png")));
  // A program that takes what comes: the frames of before are sent, and none is drawn twice.
  const std::string counting = replaced_path(kTakesAll);
  const std::size_t kept = static_cast<std::size_t>(
      std::distance(fs::directory_iterator(folder_.file("a.mp4.frames")), fs::directory_iterator{}) - 1);
  std::string first = read_text(folder_.file("a.mp4.frames/frame-00000.png"));
  const ProgramResult whole = play("a.mp4", {}, {{"PATH", counting}});
  EXPECT_EQ(whole.exit_code, 0) << whole.error;
  EXPECT_TRUE(contains(whole.out, std::to_string(5 - kept) + " of them drawn now")) << whole.out;
  EXPECT_EQ(read_text(folder_.file("a.mp4")).substr(0, first.size()), first);
  EXPECT_FALSE(fs::exists(folder_.file("a.mp4.frames")));
}

TEST_F(Play, OneVideoIsMadeByOneAtATime) {
  const std::string counting = replaced_path(kTakesAll);
  const std::string lock = folder_.file(".a.mp4.lock");
  const int file = open(lock.c_str(), O_RDWR | O_CREAT, 0644);
  ASSERT_EQ(flock(file, LOCK_EX), 0);
  const ProgramResult second = play("a.mp4", {}, {{"PATH", counting}});
  EXPECT_EQ(second.exit_code, 1);
  EXPECT_TRUE(contains(second.error, "another maquette play is making it")) << second.error;
  EXPECT_FALSE(fs::exists(folder_.file("a.mp4.frames")));
  close(file);  // as where it was killed: what it left is in nobody's way
  EXPECT_EQ(play("a.mp4", {}, {{"PATH", counting}}).exit_code, 0);
  EXPECT_FALSE(fs::exists(lock));
}

/// A link stays one, and what it names is the video.
TEST_F(Play, AVideoIsWrittenThroughALink) {
  const std::string counting = replaced_path(kTakesAll);
  fs::create_directories(folder_.file("videos"));
  fs::create_symlink("videos/of today.mp4", folder_.file("a.mp4"));
  EXPECT_EQ(play("a.mp4", {}, {{"PATH", counting}}).exit_code, 0);
  EXPECT_TRUE(fs::is_symlink(folder_.file("a.mp4")));
  EXPECT_GT(fs::file_size(folder_.file("videos/of today.mp4")), 0u);
}

TEST_F(Play, MakesAVideo) {
  if (std::system("ffmpeg -version > /dev/null 2>&1") != 0) GTEST_SKIP() << "ffmpeg is not installed";
  const ProgramResult result = play("a.mp4");
  EXPECT_EQ(result.exit_code, 0) << result.error;
  const std::string video = read_text(folder_.file("a.mp4"));
  EXPECT_TRUE(contains(video.substr(0, 64), "ftyp")) << "an MP4 file begins so";
  EXPECT_EQ(folder_.names().size(), 2u) << "nothing is left beside it";
}

}  // namespace
}  // namespace maquette
