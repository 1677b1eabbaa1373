// Keys of bakes in review files.
#include "review/review_bakes.h"

#include <gtest/gtest.h>

#include <cstdlib>
#include <nlohmann/json.hpp>

#include "review/open_review.h"
#include "scenes/error.h"
#include "tests/scenes/temporary_folder.h"
#include "tests/support/text.h"

namespace maquette {
namespace {

using Json = nlohmann::json;

constexpr const char *kOne = "00000000000000a1", *kTwo = "00000000000000b2", *kThree = "00000000000000c3";

using test::contains;

class ReviewBakes : public test::TemporaryFolder {
 protected:
  void SetUp() override {
    TemporaryFolder::SetUp();
    setenv("XDG_STATE_HOME", path("state").c_str(), 1);
    for (const char* name : {"day", "night"}) {
      Look look;
      look.name = name;
      review_.looks.push_back(look);
    }
    review_.looks[1].edits.env_rotation_deg = 90.0f;
    file_ = path("a.maquette.json");
  }
  /// Night has a light of its own.
  static std::vector<ReviewBake> bakes() {
    return list_bakes({{"", {{"visibility", kOne}, {"indirect", kTwo}}},
                       {"day", {{"visibility", kOne}, {"indirect", kTwo}}},
                       {"night", {{"visibility", kOne}, {"indirect", kThree}}}});
  }
  /// What is said of the file with these bakes.
  std::string problem(const Json& bakes) {
    Json json = Json::parse(review_text(review_, file_));
    json["bakes"] = bakes;
    return test::message_of<Error>([&] { parse_review(json.dump(), file_); });
  }

  Review review_;
  std::string file_;
};

TEST_F(ReviewBakes, AreNamedOnceForTheLooksThatShareThem) {
  const std::vector<ReviewBake> expected{{"indirect", kTwo, true, {"day"}},
                                         {"indirect", kThree, false, {"night"}},
                                         {"visibility", kOne, true, {"day", "night"}}};
  EXPECT_EQ(bakes(), expected);
  EXPECT_EQ(keys_of_look(bakes(), "night"), (BakeKeys{{"visibility", kOne}, {"indirect", kThree}}));
  EXPECT_EQ(keys_of_look(bakes(), ""), (BakeKeys{{"visibility", kOne}, {"indirect", kTwo}}));
  EXPECT_TRUE(keys_of_look(bakes(), "dusk").empty());
}

TEST_F(ReviewBakes, ComeBackFromTheFileAndAreNoPartOfTheReview) {
  save_review(file_, review_, bakes());
  std::vector<ReviewBake> back;
  EXPECT_EQ(load_review(file_, &back), review_);
  EXPECT_EQ(back, bakes());
  EXPECT_FALSE(contains(review_document(review_).dump(), kOne));
}

TEST_F(ReviewBakes, AFileWithoutThemOpens) {
  Json json = Json::parse(review_text(review_, file_, bakes()));
  json.erase("bakes");
  std::vector<ReviewBake> none = bakes();
  EXPECT_EQ(parse_review(json.dump(), file_, &none), review_);
  EXPECT_TRUE(none.empty());
}

TEST_F(ReviewBakes, BadOnesAreRefused) {
  const Json good = {{"bake", "visibility"}, {"key", kOne}, {"at_hand", true}, {"looks", {"day"}}};
  Json json = Json::parse(review_text(review_, file_));
  json["bakes"] = Json::array({good});
  EXPECT_NO_THROW(parse_review(json.dump(), file_));
  const auto with = [&](const char* member, const Json& value) {
    Json bad = good;
    bad[member] = value;
    return problem(Json::array({bad}));
  };
  for (const char* damaged : {"", "a1", "00000000000000g1", "00000000000000A1", "00000000000000a11"})
    EXPECT_TRUE(contains(with("key", damaged), std::string("bakes[0].key: \"") + damaged + "\" is no key of a bake"))
        << with("key", damaged);
  EXPECT_TRUE(contains(with("key", 7), "bakes[0].key: a text in quotes"));
  EXPECT_TRUE(contains(with("bake", "visiblity"), "did you mean visibility")) << with("bake", "visiblity");
  EXPECT_TRUE(contains(with("looks", {"nigt"}), "the review has no look \"nigt\"; did you mean night"))
      << with("looks", {"nigt"});
  EXPECT_TRUE(contains(with("kay", kOne), "did you mean key")) << with("kay", kOne);
  Json of_none = good;
  of_none["at_hand"] = false;
  of_none["looks"] = Json::array();
  EXPECT_TRUE(contains(problem(Json::array({of_none})), "bakes[0]: it belongs to no look"))
      << problem(Json::array({of_none}));
  Json other = good;
  other["key"] = kTwo;
  other["at_hand"] = false;
  EXPECT_TRUE(contains(problem(Json::array({good, other})), "bakes[1]: look \"day\" has two keys of visibility"))
      << problem(Json::array({good, other}));
  Json less = good;
  less.erase("looks");
  EXPECT_TRUE(contains(problem(Json::array({less})), "bakes[0].looks: it is missing"));
  EXPECT_TRUE(contains(problem("none"), "bakes: a list in brackets"));
}

TEST_F(ReviewBakes, OfALookThatIsGoneAreLeftOut) {
  review_.looks.erase(review_.looks.begin() + 1);
  save_review(file_, review_, bakes());
  std::vector<ReviewBake> back;
  load_review(file_, &back);
  EXPECT_EQ(back, (std::vector<ReviewBake>{{"indirect", kTwo, true, {"day"}}, {"visibility", kOne, true, {"day"}}}));
}

TEST_F(ReviewBakes, AreNoStepAndNoChange) {
  save_review(file_, review_);
  OpenReview open(file_);
  open.set_bakes(bakes());
  EXPECT_FALSE(open.changed());
  EXPECT_FALSE(open.can_undo());
  open.save(file_);
  EXPECT_FALSE(open.changed());
  EXPECT_FALSE(open.can_undo());
  std::vector<ReviewBake> back;
  load_review(file_, &back);
  EXPECT_EQ(back, bakes());
}

/// The journal has another state at hand than the file, whose keys are then of nothing that is shown.
TEST_F(ReviewBakes, HoldForLooksThatAreAsInTheFile) {
  save_review(file_, review_, bakes());
  {
    OpenReview open(file_);
    EXPECT_EQ(open.bakes(), bakes());
    Review now = open.review();
    now.look.edits.env_scale = 2.0f;
    now.looks[1].camera.eye.x += 1.0f;
    open.observe(now, false);
  }
  const OpenReview again(file_);
  ASSERT_TRUE(again.changed());
  EXPECT_EQ(again.bakes(), bakes_of_looks(bakes(), {"day", "night"}));
}

TEST_F(ReviewBakes, AreTheSameWhateverIsOnlySeen) {
  Look a, b;
  b.name = "b";
  b.camera.eye.x += 1.0f;
  b.exposure_ev = 3.0f;
  b.tonemap = "linear";
  EXPECT_TRUE(same_bakes(a, b));
  b.edits.dents.push_back({});
  EXPECT_FALSE(same_bakes(a, b));
}

}  // namespace
}  // namespace maquette
