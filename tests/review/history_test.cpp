#include "review/history.h"

#include <gtest/gtest.h>

#include "tests/support/random_reviews.h"

namespace maquette {
namespace {

using Json = nlohmann::json;

TEST(History, AThousandStepsThereAndBackGiveTheSameDocument) {
  test::RandomReviews random(4);
  Review review;
  History history(review_document(review));
  std::vector<Json> states{history.document()};
  while (states.size() <= History::kDepth) {
    random.change(&review);
    const Json now = review_document(review);
    if (now == states.back()) continue;
    // Moves of the camera alone would be one step.
    const std::size_t steps = history.undo_count();
    history.record(now);
    if (history.undo_count() > steps)
      states.push_back(now);
    else
      states.back() = now;
    if (states.size() == History::kDepth + 1) break;
  }
  ASSERT_EQ(history.undo_count(), History::kDepth);
  for (std::size_t i = states.size(); i-- > 0;) {
    ASSERT_EQ(history.document(), states[i]) << i;
    ASSERT_EQ(history.document().dump(), states[i].dump()) << i;
    ASSERT_EQ(history.undo(), i > 0);
  }
  for (const Json& state : states) {
    ASSERT_EQ(history.document(), state);
    history.redo();
  }
  EXPECT_FALSE(history.can_redo());
  EXPECT_EQ(review_from_document(history.document(), "undo"), review);
}

TEST(History, MovesOfTheCameraAreOneStep) {
  Review review;
  History history(review_document(review));
  const Json first = history.document();
  for (int i = 0; i < 10; ++i) {
    review.look.camera.eye.x += 0.1f;
    history.record(review_document(review));
  }
  EXPECT_EQ(history.undo_count(), 1u);
  review.look.edits.materials["paint"] = "builtin:a";
  history.record(review_document(review));
  review.look.camera.fov_y_rad = 1.0f;
  history.record(review_document(review));
  EXPECT_EQ(history.undo_count(), 3u);
  history.undo();
  history.undo();
  // After an undo a move begins a step of its own.
  const Json before = history.document();
  review = review_from_document(before, "undo");
  review.look.camera.eye.y = 7.0f;
  history.record(review_document(review));
  EXPECT_EQ(history.undo_count(), 2u);
  EXPECT_FALSE(history.can_redo());
  history.undo();
  EXPECT_EQ(history.document(), before);
  history.undo();
  EXPECT_EQ(history.document(), first);
  EXPECT_FALSE(history.undo());
}

TEST(History, WhatFailedLeavesNoStep) {
  Review review;
  History history(review_document(review));
  const Json good = history.document();
  review.look.edits.environment = "/missing.hdr";
  history.record(review_document(review));
  history.amend(good);
  EXPECT_FALSE(history.can_undo());
  EXPECT_EQ(history.document(), good);
  // Of a change that failed in part the rest is the step.
  review.look.edits.variant = "day";
  history.record(review_document(review));
  review.look.edits.environment = "builtin:clear-sky";
  history.amend(review_document(review));
  EXPECT_EQ(history.undo_count(), 1u);
  history.undo();
  EXPECT_EQ(history.document(), good);
}

TEST(History, DepthIsBounded) {
  Json document = {{"look", {{"a", 0}}}};
  History history(document);
  for (std::size_t i = 1; i <= History::kDepth + 50; ++i) {
    document["look"]["a"] = i;
    history.record(document);
  }
  std::size_t steps = 0;
  while (history.undo()) ++steps;
  EXPECT_EQ(steps, History::kDepth);
  EXPECT_EQ(history.document()["look"]["a"], 50);
}

TEST(History, AnotherFollowsItsRecords) {
  test::RandomReviews random(5);
  Review review;
  History history(review_document(review));
  History follower(history.document());
  history.set_sink([&](const Json& record) { follower.follow(Json::parse(record.dump())); });
  for (int i = 0; i < 400; ++i) {
    const int choice = random.pick(10);
    if (choice == 0) {
      history.undo();
    } else if (choice == 1) {
      history.redo();
    } else {
      random.change(&review);
      if (choice == 2)
        history.amend(review_document(review));
      else
        history.record(review_document(review));
    }
    review = review_from_document(history.document(), "undo");
    ASSERT_EQ(follower.document(), history.document()) << i;
    ASSERT_EQ(follower.undo_count(), history.undo_count());
    ASSERT_EQ(follower.redo_count(), history.redo_count());
  }
  Json first;
  const std::vector<Json> records = history.records(&first);
  History anew(first);
  for (const Json& record : records) anew.follow(record);
  EXPECT_EQ(anew.document(), history.document());
  EXPECT_EQ(anew.undo_count(), history.undo_count());
  EXPECT_EQ(anew.redo_count(), history.redo_count());
  const Json bad = Json::parse(R"({"step": [[{"op": "remove", "path": "/none"}], []]})");
  EXPECT_THROW(anew.follow(bad), std::exception);
}

}  // namespace
}  // namespace maquette
