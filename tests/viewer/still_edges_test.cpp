// When the window's picture gets smooth edges: at rest, unseen until it is as good as what is in sight, and never in
// the way.
#include "viewer/still_edges.h"

#include <gtest/gtest.h>

namespace maquette {
namespace {

/// A window that draws ten frames a second.
struct Window {
  StillEdges edges;
  StillEdges::Turn turn;
  int samples = 1;

  Window() { turn.still_samples = 4; }

  /// One turn: as WindowPicture does.
  void draw(bool changed = false, bool disturbed = false) {
    turn.changed = changed || disturbed;
    turn.disturbed = disturbed;
    const int before = samples;
    samples = edges.choose(turn);
    turn.frames = disturbed || samples != before ? 1 : turn.frames + 1;
    turn.now_s += 0.1;
  }
  bool hidden() const { return edges.hidden(turn.frames); }
};

TEST(StillEdges, ComeOnceThePictureRestsAndAsGoodAsItWas) {
  Window window;
  window.draw(true, true);
  for (int f = 0; f < 14; ++f) {
    window.draw();
    EXPECT_EQ(window.samples, 1) << f;
    EXPECT_FALSE(window.hidden()) << f;
  }
  int unseen = 0;
  for (int f = 0; f < 20; ++f) {
    window.draw();
    unseen += window.hidden();
  }
  EXPECT_EQ(window.samples, 4);
  EXPECT_FALSE(window.hidden());
  EXPECT_EQ(unseen, StillEdges::kMostHeld - 1);  // the next one is as good
}

TEST(StillEdges, AMoveTakesThemAway) {
  Window window;
  for (int f = 0; f < 40; ++f) window.draw();
  ASSERT_EQ(window.samples, 4);
  window.draw(true, true);
  EXPECT_EQ(window.samples, 1);
  EXPECT_FALSE(window.hidden());
  for (int f = 0; f < 100; ++f) {
    window.draw(true, true);  // a move that goes on
    EXPECT_EQ(window.samples, 1);
  }
}

TEST(StillEdges, APaintIsSeenAtOnceAndKeepsThem) {
  Window window;
  for (int f = 0; f < 40; ++f) window.draw();
  window.draw(true, false);
  EXPECT_EQ(window.samples, 4);
  EXPECT_FALSE(window.hidden());
  // While they are drawn behind the picture, too: it shows another paint.
  window.draw(true, true);
  for (int f = 0; f < 60 && !window.hidden(); ++f) window.draw();
  ASSERT_TRUE(window.hidden());
  window.draw(true, false);
  EXPECT_EQ(window.samples, 4);
  EXPECT_FALSE(window.hidden());
}

TEST(StillEdges, WaitForWhatNeedsThePictureAsItIs) {
  Window window;
  window.turn.may_begin = false;
  for (int f = 0; f < 60; ++f) window.draw();
  EXPECT_EQ(window.samples, 1);
  window.turn.may_begin = true;
  window.draw();
  EXPECT_EQ(window.samples, 4);
  window.turn.may_begin = false;  // what has begun goes on
  window.draw();
  EXPECT_EQ(window.samples, 4);
}

TEST(StillEdges, WhatCannotBeDrawnIsNotTriedAgain) {
  Window window;
  for (int f = 0; f < 60 && window.samples == 1; ++f) window.draw();
  ASSERT_EQ(window.samples, 4);
  window.edges.refuse();
  for (int f = 0; f < 60; ++f) {
    window.draw();
    EXPECT_EQ(window.samples, 1);
    EXPECT_FALSE(window.hidden());
  }
  window.draw(true, true);
  for (int f = 0; f < 60; ++f) window.draw();
  EXPECT_EQ(window.samples, 4);
}

TEST(StillEdges, NothingHappensWhereNoMoreIsAskedFor) {
  Window window;
  window.turn.moving_samples = window.turn.still_samples = 4;
  for (int f = 0; f < 60; ++f) {
    window.draw();
    EXPECT_EQ(window.samples, 4);
    EXPECT_FALSE(window.hidden());
  }
  window.turn.still_samples = 1;
  window.draw(true, true);
  EXPECT_EQ(window.samples, 4);
}

}  // namespace
}  // namespace maquette
