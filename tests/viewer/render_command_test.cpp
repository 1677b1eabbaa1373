#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "scenes/image_io.h"
#include "scenes/scene.h"
#include "test_paths.h"
#include "tests/viewer/run_program.h"
#include "viewer/stats.h"

namespace maquette {
namespace {

using Json = nlohmann::json;
using Words = std::vector<std::string>;

Words render_words(const std::string& output, const Words& more = {}) {
  Words words = {"render", "builtin:sphere", "--size", "40x24", "--samples", "8", "--output", output};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

Json run_with_stats(const TemporaryFolder& folder, const Words& more = {}) {
  Words words = render_words(folder.file("a.exr"), {"--stats", folder.file("s.json")});
  words.insert(words.end(), more.begin(), more.end());
  const ProgramResult result = run_maquette(words);
  EXPECT_EQ(result.exit_code, 0) << result.error;
  return Json::parse(read_text(folder.file("s.json")));
}

TEST(Median, OddEvenAndEmpty) {
  EXPECT_EQ(median({3.0, 1.0, 2.0}), 2.0);
  EXPECT_EQ(median({4.0, 1.0, 2.0, 3.0}), 2.5);
  EXPECT_EQ(median({}), 0.0);
}

TEST(Render, WritesALinearExrAndNothingElse) {
  const TemporaryFolder folder;
  const ProgramResult result = run_maquette(render_words(folder.file("a.exr")));
  ASSERT_EQ(result.exit_code, 0) << result.error;
  EXPECT_EQ(folder.names(), Words{"a.exr"});
  const Image image = load_hdr_image(folder.file("a.exr"));
  EXPECT_EQ(image.width, 40);
  EXPECT_EQ(image.height, 24);
  ASSERT_EQ(image.channels, 4);
  for (const float value : image.data) EXPECT_TRUE(std::isfinite(value) && value >= 0.0f);
  EXPECT_EQ(image.at(20, 12, 3), 1.0f);  // the sphere is in the middle
  EXPECT_EQ(image.at(0, 0, 3), 0.0f);    // and the sky in the corner
}

TEST(Render, WritesAPng) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_maquette(render_words(folder.file("a.png"))).exit_code, 0);
  const std::string bytes = read_text(folder.file("a.png"));
  ASSERT_GT(bytes.size(), 24u);
  EXPECT_EQ(bytes.substr(1, 3), "PNG");
  EXPECT_EQ(static_cast<unsigned char>(bytes[19]), 40);
  EXPECT_EQ(static_cast<unsigned char>(bytes[23]), 24);
}

TEST(Render, StatsHoldWhatTheContractSays) {
  const TemporaryFolder folder;
  const Json stats = run_with_stats(folder, {"--frames", "3", "--set", "bandwidth.max_level=3"});
  EXPECT_EQ(stats["scene"], "builtin:sphere");
  EXPECT_EQ(stats["mode"], "bandwidth");
  EXPECT_EQ(stats["reflections"], "auto");
  EXPECT_EQ(stats["size"], Json::array({40, 24}));
  EXPECT_FALSE(stats["device"].get<std::string>().empty());
  EXPECT_EQ(stats["settings"]["bandwidth.max_level"], 3);
  EXPECT_EQ(stats["settings"]["shading.visibility"], "auto");
  EXPECT_EQ(stats["frames"], 3);
  EXPECT_GT(stats["timing_ms"]["frame"].get<double>(), 0.0);
  EXPECT_FALSE(stats["timing_ms"]["passes"].empty());
  for (const auto& [name, ms] : stats["timing_ms"]["passes"].items()) EXPECT_GE(ms.get<double>(), 0.0) << name;
  EXPECT_FALSE(stats["memory"]["gpu_bytes"].empty());
  EXPECT_GT(stats["memory"]["peak_rss_bytes"].get<double>(), 1e6);
  for (const char* key : {"visible_pixels", "shaded_pixels", "shading_samples"})
    EXPECT_TRUE(stats["bandwidth"][key].is_number_unsigned()) << key;
  EXPECT_TRUE(stats["technique"].is_object());
  for (const Json& left_out : stats["left_out"]) {
    EXPECT_FALSE(left_out["what"].get<std::string>().empty());
    EXPECT_FALSE(left_out["why"].get<std::string>().empty());
  }
  EXPECT_FALSE(stats.contains("error"));
}

TEST(Render, PassesAndResourcesAreInTheVocabulary) {
  const std::string vocabulary = read_text(MAQUETTE_SOURCE_DIR "/docs/vocabulary.md");
  const TemporaryFolder folder;
  for (const char* mode : {"bandwidth", "uniform"}) {
    const Json stats = run_with_stats(folder, {"--mode", mode});
    for (const auto& [name, ms] : stats["timing_ms"]["passes"].items())
      EXPECT_NE(vocabulary.find("| `" + name + "` |"), std::string::npos) << name;
    for (const char* key : {"plan", "skipped"})
      for (const Json& entry : stats[key]) {
        const std::string name = entry.contains("pass") ? entry["pass"] : entry["feature"];
        EXPECT_NE(vocabulary.find("| `" + name + "` |"), std::string::npos) << name;
      }
    for (const auto& [name, bytes] : stats["memory"]["gpu_bytes"].items())
      EXPECT_NE(vocabulary.find("| `" + name + "` |"), std::string::npos) << name;
  }
}

TEST(Render, KeysOfStatsAreInTheVocabulary) {
  const std::string vocabulary = read_text(MAQUETTE_SOURCE_DIR "/docs/vocabulary.md");
  const TemporaryFolder folder;
  const Json stats = run_with_stats(folder, {"--mode", "uniform"});
  for (const auto& [key, value] : stats.items()) EXPECT_NE(vocabulary.find("`" + key), std::string::npos) << key;
  EXPECT_EQ(stats["status"]["frames_before"], 0);
  EXPECT_FALSE(stats["status"]["bakes"].contains("octree")) << "nothing wants it";
}

TEST(Render, WarnsOfAModeThatShowsNoLamps) {
  const TemporaryFolder folder;
  for (const char* mode : {"splitsum", "sg", "slf", "uniform"}) {
    std::vector<std::string> words = render_words(folder.file("a.exr"));
    words[1] = "builtin:seat";
    words.insert(words.end(), {"--mode", mode, "--set", "slf.texels=16", "--set", "slf.paths=1"});
    const ProgramResult result = run_maquette(words);
    ASSERT_EQ(result.exit_code, 0) << result.error;
    const std::string line = std::string("warning: lamps and what glows light nothing: mode ") + mode;
    EXPECT_EQ(result.error.find(line) != std::string::npos, mode[0] == 's' && mode != std::string("slf"))
        << result.error;
  }
}

TEST(Render, StatsSayWhichModeShadesWhichPart) {
  const TemporaryFolder folder;
  const std::string node = build_builtin_scene("sphere").nodes[0].name;
  const auto modes = [&](const std::vector<std::string>& parts) {
    std::vector<std::string> arguments{"--mode", "splitsum"};
    for (const std::string& mode : parts) {
      arguments.push_back("--mode-of");
      arguments.push_back(node + "=" + mode);
    }
    return run_with_stats(folder, arguments);
  };
  const Json mixed = modes({"uniform"});
  EXPECT_EQ(mixed["modes"], Json({{"*", "splitsum"}, {node, "uniform"}}));
  EXPECT_TRUE(mixed["timing_ms"]["passes"].contains("shade (uniform)"));
  for (const Json& left_out : mixed["left_out"]) EXPECT_NE(left_out["what"], "sampling") << "uniform samples";
  const Json back = modes({"uniform", "sg", "splitsum"});
  EXPECT_EQ(back["modes"], Json({{"*", "splitsum"}, {node, "splitsum"}})) << "the last one counts";
  EXPECT_TRUE(back["timing_ms"]["passes"].contains("shade")) << "one layer is left";
}

TEST(Render, OutputsReplaceNothingThatIsReadOrWrittenBeside) {
  const TemporaryFolder folder;
  save_exr(folder.file("sky.exr"), Image(8, 4, 3, 1.0f));
  const std::string sky = folder.file("sky.exr"), before = read_text(sky), picture = folder.file("a.png");
  const auto answer = [&](const std::string& output, const std::string& stats) {
    return run_maquette({"render", "builtin:sphere", "--env", sky, "--size", "8x8", "-o", output, "--stats", stats});
  };
  for (const auto& [output, stats] :
       {std::pair{sky, folder.file("s.json")}, {picture, sky}, {picture, folder.file("./a.png")}}) {
    const ProgramResult result = answer(output, stats);
    EXPECT_EQ(result.exit_code, 2);
    EXPECT_NE(result.error.find("would replace"), std::string::npos) << result.error;
  }
  EXPECT_EQ(read_text(sky), before);
  EXPECT_EQ(answer(picture, folder.file("s.json")).exit_code, 0);
}

TEST(Render, APictureOfOnePixel) {
  const TemporaryFolder folder;
  const ProgramResult result =
      run_maquette({"render", "builtin:sphere", "--size", "1x1", "--samples", "8", "-o", folder.file("a.exr")});
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const Image image = load_hdr_image(folder.file("a.exr"));
  ASSERT_EQ(image.data.size(), 4u);
  EXPECT_GT(image.at(0, 0, 1), 0.0f);
}

TEST(Render, DebugViewsAreWrittenToo) {
  const TemporaryFolder folder;
  for (const char* name : {"level.png", "bandwidth.exr"}) {
    const std::string view = std::filesystem::path(name).stem();
    ASSERT_EQ(run_maquette(render_words(folder.file(name), {"--view", view})).exit_code, 0) << name;
    EXPECT_GT(read_text(folder.file(name)).size(), 100u);
  }
}

TEST(Render, ReferenceAddsTheError) {
  const TemporaryFolder folder;
  ASSERT_EQ(run_maquette(render_words(folder.file("reference.exr"), {"--seed", "5"})).exit_code, 0);
  const Json same = run_with_stats(folder, {"--seed", "5", "--reference", folder.file("reference.exr")});
  EXPECT_EQ(same["error"]["rmse"], 0.0);  // deterministic by seed
  EXPECT_TRUE(same["error"]["psnr"].is_null());
  EXPECT_EQ(same["error"]["flip"], 0.0);
  const Json other = run_with_stats(folder, {"--seed", "6", "--reference", folder.file("reference.exr")});
  EXPECT_GT(other["error"]["relative_rmse"].get<double>(), 0.0);
  EXPECT_GT(other["error"]["flip"].get<double>(), 0.0);
  EXPECT_LT(other["error"]["ssim"].get<double>(), 1.0);
  const ProgramResult compare = run_maquette({"compare", folder.file("a.exr"), folder.file("reference.exr"), "--json"});
  ASSERT_EQ(compare.exit_code, 0) << compare.error;
  EXPECT_EQ(Json::parse(compare.out), other["error"]);
  const ProgramResult told = run_maquette(render_words(
      folder.file("b.exr"), {"--reference", folder.file("reference.exr"), "--target-error", "1e-6", "--time", "0.1"}));
  ASSERT_EQ(told.exit_code, 0) << told.error;
  EXPECT_NE(told.out.find("relative RMSE"), std::string::npos) << told.out;
  EXPECT_NE(told.out.find("not reached"), std::string::npos) << told.out;
  const ProgramResult size = run_maquette({"render", "builtin:sphere", "--size", "8x8", "-o", folder.file("b.exr"),
                                           "--reference", folder.file("reference.exr")});
  EXPECT_EQ(size.exit_code, 1);
  EXPECT_NE(size.error.find("40x24"), std::string::npos) << size.error;
}

/// Frames of mode reference take several paths each.
TEST(Render, TimeOfTheReferenceIsToldInPaths) {
  const TemporaryFolder folder;
  const ProgramResult result = run_maquette(
      render_words(folder.file("a.exr"), {"--stats", folder.file("s.json"), "--mode", "reference", "--time", "0.3"}));
  ASSERT_EQ(result.exit_code, 0) << result.error;
  const Json stats = Json::parse(read_text(folder.file("s.json")));
  const std::string told = "mode reference, ";
  const std::size_t at = result.out.find(told);
  ASSERT_NE(at, std::string::npos) << result.out;
  const double paths = stats["technique"]["paths"].get<double>() / (40.0 * 24.0);
  EXPECT_NEAR(std::stod(result.out.substr(at + told.size())), paths, 0.01 * paths) << result.out;
}

TEST(Render, TimeAveragesFramesAndTellsTheErrorLeft) {
  const TemporaryFolder folder;
  const Json stats = run_with_stats(folder, {"--time", "0.5", "--mode", "uniform"});
  const int frames = stats["accumulation"]["frames"];
  EXPECT_GE(frames, 1);
  // The last frame is the one that ends nearest to the time.
  const double frame_s = 1e-3 * stats["timing_ms"]["frame"].get<double>();
  EXPECT_GT(stats["accumulation"]["seconds"].get<double>(), 0.5 - 2.0 * frame_s - 0.1);
  if (frames >= 2) {
    EXPECT_GT(stats["accumulation"]["estimated_relative_rmse"].get<double>(), 0.0);
  }
}

TEST(Render, WhatNoNoiseCountsIsSaid) {
  const TemporaryFolder folder;
  const auto said = [&](const Words& more) {
    Words words = render_words(folder.file("a.exr"), {"--target-error", "0.05"});
    words.insert(words.end(), more.begin(), more.end());
    return run_maquette(words).error;
  };
  EXPECT_NE(said({"--set", "shading.visibility=baked"}).find("shadows stay blurred"), std::string::npos);
  EXPECT_EQ(said({}).find("blurred"), std::string::npos);
}

TEST(Render, InterruptedItLeavesThePictureSoFar) {
  const TemporaryFolder folder;
  for (const std::string mode : {"reference", "uniform"}) {
    const std::string picture = folder.file(mode + ".exr");
    Words words = {"-c",
                   "\"$@\" & p=$!; until grep -q 'Ctrl-C keeps' errors; do sleep 0.05; done; kill -INT $p; wait $p",
                   "bash", MAQUETTE_PROGRAM};
    for (const std::string& word : render_words(picture, {"--mode", mode, "--time", "20"})) words.push_back(word);
    words[1] = "exec 2>errors; " + words[1];
    const ProgramResult result = run_in_folder(folder.path().string(), "bash", words);
    EXPECT_EQ(result.exit_code, 1);
    const std::string told = read_text(folder.file("errors"));
    EXPECT_NE(told.find(" of 20 s"), std::string::npos) << told;
    EXPECT_NE(told.find("interrupted after"), std::string::npos) << told;
    EXPECT_NE(told.find("holds the picture so far"), std::string::npos) << told;
    const Image image = load_hdr_image(picture);
    EXPECT_GT(image.at(20, 12, 1), 0.0f);
    std::filesystem::remove(folder.file("errors"));
  }
}

TEST(Render, TargetErrorStopsEarly) {
  const TemporaryFolder folder;
  const Json stats = run_with_stats(folder, {"--target-error", "0.5", "--time", "60", "--mode", "uniform"});
  EXPECT_LE(stats["accumulation"]["estimated_relative_rmse"].get<double>(), 0.5);
  EXPECT_LE(stats["accumulation"]["frames"].get<int>(), 4) << "the error is met long before the time is up";
}

TEST(Render, StatsToStandardOutputAreOnlyJson) {
  const TemporaryFolder folder;
  const ProgramResult result = run_maquette(render_words(folder.file("a.exr"), {"--stats", "-"}));
  EXPECT_EQ(Json::parse(result.out)["mode"], "bandwidth");
}

}  // namespace
}  // namespace maquette
