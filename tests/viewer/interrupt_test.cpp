#include "viewer/interrupt.h"

#include <gtest/gtest.h>

namespace maquette {
namespace {

volatile std::sig_atomic_t seen = 0;

TEST(Interrupt, TheGuardKeepsTheFirstSignalAndGivesBackTheHandlers) {
  seen = 0;
  const auto before = std::signal(SIGINT, [](int) { seen = seen + 1; });
  {
    const InterruptGuard guard;
    EXPECT_FALSE(InterruptGuard::asked());
    std::raise(SIGINT);
    EXPECT_TRUE(InterruptGuard::asked());
    EXPECT_TRUE(InterruptGuard::flag());
    struct sigaction now {};
    sigaction(SIGINT, nullptr, &now);
    EXPECT_EQ(now.sa_handler, SIG_DFL);  // the second one ends the program
  }
  EXPECT_EQ(seen, 0);
  std::raise(SIGINT);
  EXPECT_EQ(seen, 1);
  {
    const InterruptGuard again;
    EXPECT_FALSE(InterruptGuard::asked());
  }
  std::signal(SIGINT, before);
}

}  // namespace
}  // namespace maquette
