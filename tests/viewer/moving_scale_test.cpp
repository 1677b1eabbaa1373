// Resolution of the window's picture while something moves: for given frame times it settles and stays.
#include "viewer/moving_scale.h"

#include <gtest/gtest.h>

namespace maquette {
namespace {

using Kind = MovingScale::Kind;
constexpr double kPx = 1e6;

/// A move with frames of `ms_per_mpx` milliseconds per megapixel: the scale of the last one, and how often it changed.
struct Move {
  float scale = 0.0f;
  int changes = 0;
};
Move move(MovingScale& moving, Kind kind, double ms_per_mpx, int frames) {
  Move m;
  for (int f = 0; f < frames; ++f) {
    const float scale = moving.next_scale(kind, kPx, 1.0f);
    m.changes += f > 0 && scale != m.scale;
    m.scale = scale;
    moving.note(kind, ms_per_mpx * scale * scale, kPx * scale * scale);
  }
  return m;
}

TEST(MovingScale, ALightThatIsCheapToTurnKeepsItsSize) {
  MovingScale moving;
  moving.note_still(600.0, kPx);  // frames without reuse are slow
  const Move m = move(moving, Kind::light, 90.0, 20);
  EXPECT_EQ(m.scale, 1.0f);
  EXPECT_EQ(m.changes, 0);
}

TEST(MovingScale, TheSizeSettlesWhereFramesAreFluid) {
  for (const double cost : {150.0, 300.0, 390.0}) {
    MovingScale moving;
    const Move m = move(moving, Kind::light, cost, 40);
    EXPECT_LE(cost * m.scale * m.scale, MovingScale::kFluid_ms) << cost;
    EXPECT_GT(cost * m.scale * m.scale, 0.45 * MovingScale::kFluid_ms) << cost;
    EXPECT_LE(m.changes, 2) << cost;
    moving.rest();
    EXPECT_EQ(moving.next_scale(Kind::light, kPx, 1.0f), m.scale) << "the next move begins as this one ended";
  }
}

TEST(MovingScale, NeverBelowHalfTheResolution) {
  MovingScale moving;
  moving.note_still(5000.0, kPx);
  const Move m = move(moving, Kind::other, 5000.0, 20);
  EXPECT_EQ(m.scale, 0.5f);
  EXPECT_EQ(m.changes, 0);
}

TEST(MovingScale, OneSlowFrameChangesNothing) {
  MovingScale moving;
  move(moving, Kind::light, 60.0, 5);
  moving.note(Kind::light, 400.0, kPx);
  EXPECT_EQ(moving.next_scale(Kind::light, kPx, 1.0f), 1.0f);
}

TEST(MovingScale, ACameraThatMovesIsJudgedByItsOwnFrames) {
  MovingScale moving;
  moving.note_still(390.0, kPx);
  EXPECT_EQ(moving.next_scale(Kind::other, kPx, 1.0f), 0.5f);
  move(moving, Kind::light, 60.0, 5);
  moving.rest();
  EXPECT_EQ(moving.next_scale(Kind::other, kPx, 1.0f), 0.5f);
  EXPECT_EQ(moving.next_scale(Kind::light, kPx, 1.0f), 1.0f);
}

TEST(MovingScale, NeverAboveWhatIsAllowed) {
  MovingScale moving;
  EXPECT_LE(moving.next_scale(Kind::light, kPx, 0.6f), 0.6f);
  EXPECT_LE(moving.next_scale(Kind::light, kPx, 0.1f), 0.1f);
}

}  // namespace
}  // namespace maquette
