#include "review/look_json.h"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "review/json_reader.h"
#include "review/review.h"
#include "scenes/error.h"
#include "tests/scenes/temporary_folder.h"
#include "tests/support/random_reviews.h"
#include "tests/support/text.h"

namespace maquette {
namespace {

using Json = nlohmann::json;

std::string same(const std::string& source) { return source; }

template <typename Call>
std::string error_of(const Call& call) {
  return test::message_of<Error>(call);
}

using ReviewFile = test::TemporaryFolder;

using test::contains;

TEST(LookJson, EveryValueComesBackAsItWas) {
  test::RandomReviews random(1);
  Look look;
  for (int i = 0; i < 500; ++i) {
    random.change(&look);
    const Json json = look_json(look, same);
    EXPECT_EQ(look_from_json(Json::parse(json.dump()), "look", same), look) << json.dump(1);
    EXPECT_EQ(Json::parse(json.dump()), json);
  }
}

TEST(LookJson, HasDefaultsToo) {
  const Json json = look_json(Look(), same);
  EXPECT_EQ(json.at("settings").size(), setting_declarations().size());
  EXPECT_EQ(json.at("exposure_ev"), "auto");
}

TEST(LookJson, FloatsAreShort) {
  EXPECT_EQ(shortest(0.1f).dump(), "0.1");
  EXPECT_EQ(shortest(-1.5f).dump(), "-1.5");
  test::RandomReviews random(2);
  for (int i = 0; i < 1000; ++i) {
    const float value = std::exp(random.real(-50.0f, 50.0f));
    EXPECT_EQ(Json::parse(shortest(value).dump()).get<float>(), value);
  }
}

TEST(LookJson, NamesWhatIsWrong) {
  const Json good = look_json(Look(), same);
  const auto problem = [&](const std::string& pointer, const Json& value) {
    Json bad = good;
    bad[Json::json_pointer(pointer)] = value;
    return error_of([&] { look_from_json(bad, "f.maquette.json: look", same); });
  };
  EXPECT_TRUE(contains(problem("/tonmap", "linear"),
                       "f.maquette.json: look.tonmap: this version knows no such member; "
                       "did you mean tonemap"));
  EXPECT_TRUE(contains(problem("/tonemap", "linar"), "did you mean linear"));
  EXPECT_TRUE(contains(problem("/camera/eye", {1, 2}), "look.camera.eye: 3 numbers in brackets are expected"));
  EXPECT_TRUE(contains(problem("/camera/fov_y_rad", 4), "look.camera.fov_y_rad: 4 is out of range"));
  EXPECT_TRUE(contains(problem("/camera/target", good["camera"]["eye"]), "it is where the eye is"));
  EXPECT_TRUE(contains(problem("/mode", "no mode"), "look.mode"));
  EXPECT_TRUE(contains(problem("/settings/shading.visbility", "none"), "did you mean shading.visibility"));
  EXPECT_TRUE(contains(problem("/settings/shading.visibility", "som"), "is not one of its values"));
  EXPECT_TRUE(contains(problem("/settings/shading.visibility", 3), "look.settings"));
  EXPECT_TRUE(contains(problem("/environment", 3), "an object in braces"));
  EXPECT_TRUE(contains(problem("/materials/a", 3), "look.materials.a: a text in quotes"));
  EXPECT_TRUE(contains(problem("/hidden", {1}), "look.hidden: texts in quotes"));
  Json less = good;
  less.erase("variant");
  EXPECT_TRUE(contains(error_of([&] { look_from_json(less, "look", same); }), "look.variant: it is missing"));
}

TEST_F(ReviewFile, ComesBackAsItWas) {
  const std::string file = path("a.maquette.json");
  test::RandomReviews random(3);
  Review review;
  for (int i = 0; i < 200; ++i) {
    random.change(&review);
    if (i % 20 > 0) continue;
    save_review(file, review);
    EXPECT_EQ(load_review(file), review);
    EXPECT_EQ(review_from_document(review_document(review), "undo"), review);
  }
}

TEST_F(ReviewFile, SourcesAreRelativeAndMoveWithTheFolder) {
  std::filesystem::create_directories(path("one/hdr"));
  std::ofstream(path("one/hdr/hall.hdr")) << "light";
  Review review;
  review.look.edits.environment = path("one/hdr/hall.hdr");
  review.look.edits.materials["paint"] = path("one/missing.binary");
  save_review(path("one/a.maquette.json"), review);
  const std::string text = read(path("one/a.maquette.json"));
  EXPECT_EQ(text.find(path("")), std::string::npos) << text;
  std::filesystem::rename(path("one"), path("two"));
  const std::string moved = path("two/a.maquette.json");
  const Review back = load_review(moved);
  EXPECT_EQ(back.look.edits.environment, path("two/hdr/hall.hdr"));
  EXPECT_EQ(missing_sources(back), std::vector<std::string>{path("two/missing.binary")});
  EXPECT_TRUE(changed_sources(moved).empty());
  std::ofstream(path("two/hdr/hall.hdr")) << "other light";
  EXPECT_EQ(changed_sources(moved), std::vector<std::string>{"hdr/hall.hdr"});
}

TEST_F(ReviewFile, BadOnesAreRefused) {
  Review review;
  const std::string file = "/nowhere/a.maquette.json";
  Json json = Json::parse(review_text(review, file));
  const auto problem = [&](const Json& bad) { return error_of([&] { parse_review(bad.dump(), file); }); };
  Json newer = json;
  newer["maquette_review"] = 2;
  EXPECT_TRUE(contains(problem(newer), file + ": it is of a newer version of the program; update the program"));
  Json unknown = json;
  unknown["lookz"] = Json::array();
  EXPECT_TRUE(contains(problem(unknown), "did you mean look")) << problem(unknown);
  Json twice = json;
  twice["look"]["name"] = "day";
  twice["looks"] = {twice["look"], twice["look"]};
  EXPECT_TRUE(contains(problem(twice), "looks: two of them are named \"day\"")) << problem(twice);
  twice["looks"] = Json::array({json["look"]});  // braces around one are not an array for every compiler
  EXPECT_TRUE(contains(problem(twice), "a look has no name"));
  Json outside = json;
  outside["regions"] = {{{"x", 0.5}, {"y", 0.0}, {"width", 0.75}, {"height", 1.0}}};
  EXPECT_TRUE(contains(problem(outside), "regions[0]: it reaches outside the picture")) << problem(outside);
  Json first_ones = json;
  first_ones.erase("regions");
  first_ones.erase("inspection");
  EXPECT_NO_THROW(parse_review(first_ones.dump(), file)) << "the first reviews had neither";
  Json inspected = json;
  inspected["inspection"]["polarisation"] = "sunglases";
  EXPECT_TRUE(
      contains(problem(inspected), "inspection.polarisation: there is no \"sunglases\"; did you mean sunglasses"))
      << problem(inspected);
  inspected = json;
  inspected["inspection"]["background_cdm2"] = -1.0;
  EXPECT_TRUE(contains(problem(inspected), "inspection.background_cdm2")) << problem(inspected);
  inspected = json;
  inspected["inspection"]["eye_box_mm"] = {100.0};
  EXPECT_TRUE(contains(problem(inspected), "inspection.eye_box_mm: 2 numbers")) << problem(inspected);
  inspected = json;
  inspected["inspection"]["eyebox_mm"] = {100.0, 50.0};
  EXPECT_TRUE(contains(problem(inspected), "did you mean eye_box_mm")) << problem(inspected);
  const std::string damaged = error_of([&] { parse_review(json.dump().substr(0, 200), file); });
  EXPECT_TRUE(contains(damaged, "it is damaged") && contains(damaged, "journal")) << damaged;
  EXPECT_TRUE(contains(error_of([&] { load_review("/nowhere/b.maquette.json"); }), "does not exist"));
}

}  // namespace
}  // namespace maquette
