// Linked into every test program: holds each frame that a test draws against its plan.
#include <gtest/gtest.h>

#include <algorithm>

#include "render/frame/stats.h"

namespace maquette {
namespace {

/// Planned = executed + skipped with its reason, and that is what is timed.
void expect_planned_is_done(const FrameStats& stats) {
  std::vector<PlannedPass> planned = stats.plan.preparations;
  planned.insert(planned.end(), stats.plan.passes.begin(), stats.plan.passes.end());
  for (const PlannedPass& pass : planned) {
    const auto is = [&](const auto& other) { return other.name == pass.name && other.layer == pass.layer; };
    const auto timed = std::count_if(stats.passes.begin(), stats.passes.end(), is);
    const auto skipped = std::count_if(stats.skipped.begin(), stats.skipped.end(), is);
    EXPECT_EQ(timed + skipped, 1) << pass.name << " of layer " << pass.layer << ": executed " << timed << ", skipped "
                                  << skipped;
  }
  const auto is_planned = [&](const auto& entry) {
    return std::any_of(planned.begin(), planned.end(),
                       [&](const PlannedPass& pass) { return pass.name == entry.name && pass.layer == entry.layer; });
  };
  for (const PassTime& pass : stats.passes) EXPECT_TRUE(is_planned(pass)) << pass.name << " was timed, but not planned";
  for (const SkippedPass& pass : stats.skipped) {
    EXPECT_TRUE(is_planned(pass)) << pass.name << " was skipped, but not planned";
    EXPECT_FALSE(pass.why.empty()) << pass.name;
  }
}

[[maybe_unused]] const bool kObserves = [] {
  frame_observer = expect_planned_is_done;
  return true;
}();

}  // namespace
}  // namespace maquette
