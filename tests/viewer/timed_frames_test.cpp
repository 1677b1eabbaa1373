// Frames until a time is over, by a clock that the test moves.
#include "viewer/timed_frames.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace maquette {
namespace {

/// Draws frames until it is over; the time of each comes from `frame_s`.
template <typename FrameTime>
std::pair<int, double> draw_until_over(double limit_s, const FrameTime& frame_s) {
  double now_s = 17.0;
  TimedFrames frames(limit_s, [&] { return now_s; });
  int count = 0;
  while (!frames.over()) {
    now_s += frame_s(count++);
    frames.end_frame();
  }
  return {count, frames.elapsed_s()};
}

TEST(TimedFrames, CountsOfEvenFrames) {
  const auto count = [](double limit_s, double frame_s) {
    return draw_until_over(limit_s, [&](int) { return frame_s; }).first;
  };
  EXPECT_EQ(count(10.0, 0.1), 100);
  EXPECT_EQ(count(10.0, 0.3), 33) << "9.9 s is nearer than 10.2 s";
  EXPECT_EQ(count(10.0, 0.7), 14) << "9.8 s";
  EXPECT_EQ(count(10.0, 0.96), 10) << "9.6 s is nearer than 10.56 s";
  EXPECT_EQ(count(10.0, 2.0), 5) << "exactly";
  EXPECT_EQ(count(10.0, 3.0), 3) << "a fourth would end at 12 s";
  EXPECT_EQ(count(10.0, 9.0), 1);
  EXPECT_EQ(count(10.0, 25.0), 1) << "there is always one";
}

TEST(TimedFrames, ShortFramesKeepTheTimeToATenth) {
  std::mt19937 random(5);
  for (int run = 0; run < 2000; ++run) {
    const double limit_s = std::exp(std::uniform_real_distribution<double>(-3.0, 6.0)(random));
    const double mean_s = limit_s * std::uniform_real_distribution<double>(1e-3, 0.066)(random);
    std::uniform_real_distribution<double> frame_s(0.5 * mean_s, 1.5 * mean_s);
    const double took_s = draw_until_over(limit_s, [&](int) { return frame_s(random); }).second;
    EXPECT_NEAR(took_s, limit_s, 0.1 * limit_s) << "frames of about " << mean_s << " s";
  }
}

TEST(TimedFrames, LongFramesDoNotOverrun) {
  std::mt19937 random(6);
  for (int run = 0; run < 500; ++run) {
    const double frame_s = std::uniform_real_distribution<double>(0.11, 0.9)(random);
    const auto [count, took_s] = draw_until_over(1.0, [&](int) { return frame_s; });
    EXPECT_EQ(count, static_cast<int>(1.0 / frame_s));
    EXPECT_LE(took_s, 1.0);
  }
}

TEST(TimedFrames, OneSlowFrameDoesNotEndIt) {
  // The third takes eight times as long as the others, which the median does not follow.
  const auto [count, took_s] = draw_until_over(10.0, [](int i) { return i == 2 ? 4.0 : 0.5; });
  EXPECT_EQ(count, 13);
  EXPECT_DOUBLE_EQ(took_s, 10.0);
}

}  // namespace
}  // namespace maquette
