// When the window's picture gets smooth edges: once nothing moves, hidden until it has no more noise than the picture
// on screen, and without delaying anything else.
#include "viewer/still_edges.h"

#include <gtest/gtest.h>

namespace maquette {
namespace {

/// A window that draws ten frames a second.
struct Window {
  StillEdges edges;
  StillEdges::Input input;
  int samples = 1;

  Window() { input.still_samples = 4; }

  /// One iteration, as in WindowPicture.
  void draw(bool changed = false, bool disturbed = false) {
    input.changed = changed || disturbed;
    input.disturbed = disturbed;
    const int before = samples;
    samples = edges.next_samples(input);
    input.frames = disturbed || samples != before ? 1 : input.frames + 1;
    input.now_s += 0.1;
  }
  bool hidden() const { return edges.hidden(input.frames); }
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
  EXPECT_EQ(unseen, StillEdges::kMostHeld - 1);  // the next one has no more noise
}

TEST(StillEdges, AMoveTakesThemAway) {
  Window window;
  for (int f = 0; f < 40; ++f) window.draw();
  ASSERT_EQ(window.samples, 4);
  window.draw(true, true);
  EXPECT_EQ(window.samples, 1);
  EXPECT_FALSE(window.hidden());
  for (int f = 0; f < 100; ++f) {
    window.draw(true, true);  // a move that continues
    EXPECT_EQ(window.samples, 1);
  }
}

TEST(StillEdges, ASwappedMaterialIsVisibleAtOnceAndKeepsThem) {
  Window window;
  for (int f = 0; f < 40; ++f) window.draw();
  window.draw(true, false);
  EXPECT_EQ(window.samples, 4);
  EXPECT_FALSE(window.hidden());
  // The same while they are still hidden: the picture shows another material.
  window.draw(true, true);
  for (int f = 0; f < 60 && !window.hidden(); ++f) window.draw();
  ASSERT_TRUE(window.hidden());
  window.draw(true, false);
  EXPECT_EQ(window.samples, 4);
  EXPECT_FALSE(window.hidden());
}

TEST(StillEdges, WaitForWhatNeedsThePictureAsItIs) {
  Window window;
  window.input.may_begin = false;
  for (int f = 0; f < 60; ++f) window.draw();
  EXPECT_EQ(window.samples, 1);
  window.input.may_begin = true;
  window.draw();
  EXPECT_EQ(window.samples, 4);
  window.input.may_begin = false;  // what has begun continues
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
  window.input.moving_samples = window.input.still_samples = 4;
  for (int f = 0; f < 60; ++f) {
    window.draw();
    EXPECT_EQ(window.samples, 4);
    EXPECT_FALSE(window.hidden());
  }
  window.input.still_samples = 1;
  window.draw(true, true);
  EXPECT_EQ(window.samples, 4);
}

}  // namespace
}  // namespace maquette
