#include "viewer/bake_clock.h"

#include <gtest/gtest.h>

namespace maquette {
namespace {

TEST(BakeClock, TellsWhatIsLeftFromWhatIsMade) {
  BakeClock clock;
  const auto left = [&](double now_s, double progress) {
    const auto found = clock.update(now_s, {{"prt", progress}});
    return found.contains("prt") ? found.at("prt") : -1.0;
  };
  // Half was on the disk; the rest goes on evenly, 1 % a second.
  EXPECT_EQ(left(100.0, 0.0), -1.0);
  EXPECT_EQ(left(100.5, 0.5), -1.0);
  EXPECT_EQ(left(101.5, 0.51), -1.0);
  EXPECT_NEAR(left(120.5, 0.70), 30.0, 3.0);
  EXPECT_NEAR(left(140.5, 0.90), 10.0, 1.0);
  // Another run begins anew.
  EXPECT_EQ(left(141.0, 0.01), -1.0);
  EXPECT_NEAR(left(161.0, 0.21), 79.0, 6.0);
  EXPECT_TRUE(clock.update(170.0, {}).empty());
}

}  // namespace
}  // namespace maquette
