// Fits on a background thread: their results equal those of a direct fit, and fits that are no longer needed are
// cancelled.
#include "render/bezier/patch_fit_store.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

/// A pane of waves that takes many patches.
PatchFitPart wavy_part(std::uint64_t hash, int side) {
  Primitive p = test::make_grid({-1.0f, -0.6f, 0.0f}, {2, 0, 0}, {0, 1.2f, 0}, side, 0);
  for (std::size_t i = 0; i < p.positions.size(); ++i) {
    glm::vec3& at = p.positions[i];
    at.z = 0.1f * std::sin(5.0f * at.x) * std::cos(4.0f * at.y);
    p.normals[i] = glm::normalize(glm::vec3(-0.5f * std::cos(5.0f * at.x) * std::cos(4.0f * at.y),
                                            0.4f * std::sin(5.0f * at.x) * std::sin(4.0f * at.y), 1.0f));
  }
  return {.hash = hash, .positions = p.positions, .normals = p.normals, .uvs = {}, .indices = p.indices, .cage = {}};
}

TEST(PatchFitStore, MatchesADirectFit) {
  const PatchFitPart part = wavy_part(7, 12);
  PatchFitStore store;
  const auto make_part = [&](std::size_t) { return part; };
  store.want({7}, make_part);
  EXPECT_EQ(store.find(7), nullptr);
  store.wait();
  EXPECT_TRUE(store.update());
  EXPECT_FALSE(store.busy());
  EXPECT_FALSE(store.update());
  const auto fit = store.find(7);
  ASSERT_NE(fit, nullptr);
  const PatchFit direct = fit_patches(part.positions, part.normals, part.uvs, part.indices);
  ASSERT_EQ(fit->patches.size(), direct.patches.size());
  for (std::size_t k = 0; k < direct.patches.size(); ++k) EXPECT_EQ(fit->patches[k].points, direct.patches[k].points);
  // Existing fits are not computed again, and fits that are no longer requested are discarded.
  int made = 0;
  const auto make_other = [&](std::size_t) {
    ++made;
    return wavy_part(8, 4);
  };
  store.want({7}, make_other);
  EXPECT_EQ(made, 0);
  store.want({7, 8, 8}, make_other);
  EXPECT_EQ(made, 1);
  store.wait();
  EXPECT_TRUE(store.update());
  EXPECT_EQ(store.find(7), fit);
  EXPECT_NE(store.find(8), nullptr);
  store.want({8}, make_other);
  EXPECT_EQ(store.find(7), nullptr);
}

TEST(PatchFitStore, CancelledFitsAreNotShown) {
  PatchFitStore store;
  store.want({1}, [](std::size_t) { return wavy_part(1, 40); });
  store.want({2}, [](std::size_t) { return wavy_part(2, 4); });
  store.wait();
  EXPECT_TRUE(store.update());
  EXPECT_EQ(store.find(1), nullptr);
  EXPECT_NE(store.find(2), nullptr);
  store.want({1}, [](std::size_t) { return wavy_part(1, 40); });
  store.cancel();
  store.wait();
  EXPECT_FALSE(store.update());
  // Requested again, it is delivered.
  store.want({1}, [](std::size_t) { return wavy_part(1, 4); });
  store.wait();
  EXPECT_TRUE(store.update());
  EXPECT_NE(store.find(1), nullptr);
}

/// The fit polls often for cancellation, and ends within a few polls on each thread.
TEST(PatchFitStore, AStoppedFitEndsSoon) {
  const PatchFitPart part = wavy_part(1, 40);
  const auto polls_of = [&](int stop_after) {
    std::atomic<int> polls{0};
    fit_patches(part.positions, part.normals, {}, part.indices, {.stop = [&] { return ++polls > stop_after; }});
    return polls.load();
  };
  const int all = polls_of(1000000);
  EXPECT_GT(all, 300);
  for (const int stop_after : {0, 3, 30, 150}) EXPECT_LT(polls_of(stop_after), stop_after + 60);
}

TEST(PatchFitStore, ProgressGrowsToTheEnd) {
  std::atomic<bool> cancel{false};
  std::vector<double> seen;
  const auto fits =
      run_patch_fit_job({wavy_part(1, 12), wavy_part(2, 8)}, cancel, [&](double p) { seen.push_back(p); });
  ASSERT_TRUE(fits.has_value());
  EXPECT_EQ(fits->size(), 2u);
  ASSERT_GT(seen.size(), 2u);
  EXPECT_TRUE(std::is_sorted(seen.begin(), seen.end()));
  EXPECT_GT(seen.front(), 0.0);
  EXPECT_DOUBLE_EQ(seen.back(), 1.0);
  // Cancelled after the first patch.
  EXPECT_FALSE(run_patch_fit_job({wavy_part(1, 12), wavy_part(2, 8)}, cancel, [&](double) { cancel = true; }));
}

}  // namespace
}  // namespace maquette
