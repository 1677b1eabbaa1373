// How coarse the window's picture is while something moves: given what frames take, its size settles and stays.
#include "viewer/moving_scale.h"

#include <gtest/gtest.h>

namespace maquette {
namespace {

using Kind = MovingScale::Kind;
constexpr double kPx = 1e6;

/// Frames of a move that take `ms_per_mpx` each; the scale of the last one, and how often it changed.
struct Move {
  float scale = 0.0f;
  int changes = 0;
};
Move move(MovingScale& chooser, Kind kind, double ms_per_mpx, int frames) {
  Move m;
  for (int f = 0; f < frames; ++f) {
    const float scale = chooser.choose(kind, kPx, 1.0f);
    m.changes += f > 0 && scale != m.scale;
    m.scale = scale;
    chooser.note(kind, ms_per_mpx * scale * scale, kPx * scale * scale);
  }
  return m;
}

TEST(MovingScale, ALightThatIsCheapToTurnKeepsItsSize) {
  MovingScale chooser;
  chooser.note_still(600.0, kPx);  // frames from nothing are slow
  const Move m = move(chooser, Kind::light, 90.0, 20);
  EXPECT_EQ(m.scale, 1.0f);
  EXPECT_EQ(m.changes, 0);
}

TEST(MovingScale, TheSizeSettlesWhereFramesAreFluid) {
  for (const double cost : {150.0, 300.0, 700.0}) {
    MovingScale chooser;
    const Move m = move(chooser, Kind::light, cost, 40);
    EXPECT_LE(cost * m.scale * m.scale, MovingScale::kFluid_ms) << cost;
    EXPECT_GT(cost * m.scale * m.scale, 0.45 * MovingScale::kFluid_ms) << cost;
    EXPECT_LE(m.changes, 2) << cost;
    chooser.rest();
    EXPECT_EQ(chooser.choose(Kind::light, kPx, 1.0f), m.scale) << "the next move begins as this one ended";
  }
}

TEST(MovingScale, OneSlowFrameChangesNothing) {
  MovingScale chooser;
  move(chooser, Kind::light, 60.0, 5);
  chooser.note(Kind::light, 400.0, kPx);
  EXPECT_EQ(chooser.choose(Kind::light, kPx, 1.0f), 1.0f);
}

TEST(MovingScale, ACameraThatMovesIsJudgedByItsOwnFrames) {
  MovingScale chooser;
  chooser.note_still(390.0, kPx);
  EXPECT_EQ(chooser.choose(Kind::other, kPx, 1.0f), 0.5f);
  move(chooser, Kind::light, 60.0, 5);
  chooser.rest();
  EXPECT_EQ(chooser.choose(Kind::other, kPx, 1.0f), 0.5f);
  EXPECT_EQ(chooser.choose(Kind::light, kPx, 1.0f), 1.0f);
}

TEST(MovingScale, NeverAboveWhatIsAllowed) {
  MovingScale chooser;
  EXPECT_LE(chooser.choose(Kind::light, kPx, 0.6f), 0.6f);
  EXPECT_LE(chooser.choose(Kind::light, kPx, 0.1f), 0.1f);
}

}  // namespace
}  // namespace maquette
