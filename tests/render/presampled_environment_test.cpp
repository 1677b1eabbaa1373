// Precomputed directions, compared with the tables from which they were sampled.
#include "render/reference/presampled_environment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "render/reference/path_scene.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

class PresampledEnvironmentTest : public testing::Test {
 protected:
  PresampledEnvironmentTest() {
    options_.env_rotation_rad = 0.8f;
    options_.env_scale = 3.0f;
  }
  const TracedEnvironment& traced() const { return scene_->environment; }
  int leaves() const { return traced().partition->leaf_count(); }

  std::shared_ptr<const PathScene> scene_ =
      build_path_scene({.scene = test::sphere_of(Material()),
                        .environment = test::sky_with_lamp({1.0f, 0.8f, 0.5f}, {1e5f, 8e4f, 5e4f})});
  PathOptions options_;
};

TEST_F(PresampledEnvironmentTest, MatchesTheEnvironmentAtItsDirections) {
  const EnvironmentLight light(traced(), options_);
  PresampledEnvironment samples(light, leaves(), 1u << 20, 7);
  samples.prepare(1);
  std::mt19937 random(11);
  std::uniform_real_distribution<float> uniform(0.0f, 0x1.fffffep-1f);
  int compared = 0, alike = 0;
  for (int i = 0; i < 20000; ++i) {
    const int leaf = i % leaves();
    const PresampledDirection& s = samples.at(0, leaf, {uniform(random), uniform(random)});
    ASSERT_NEAR(glm::length(s.direction), 1.0f, 1e-5f);
    if (!(s.density > 0.0f)) continue;
    const glm::vec4 told = light.radiance_and_density(s.direction);
    // Directions at a texel's edge may be rounded to the neighbouring texel, which has another density.
    const glm::vec3 own = shared::latlong_rotate(s.direction, std::cos(0.8f), -std::sin(0.8f));
    const EnvironmentLookup found = traced().look_up(own);
    if (traced().partition->leaf_at(found.x, found.y) != leaf) continue;
    for (int c = 0; c < 3; ++c) ASSERT_NEAR(s.radiance[c], told[c], 1e-3f * told[c] + 1e-6f);
    alike += std::abs(s.density - told.w) <= 1e-2f * told.w ? 1 : 0;
    ++compared;
  }
  EXPECT_GT(compared, 19000);
  // The rest lies at the edge of a texel of a different density.
  EXPECT_GT(alike, 0.99 * compared);
}

/// The mean of light over density in a leaf, times the probability of the leaf, is the leaf's share of all light.
TEST_F(PresampledEnvironmentTest, ServesOnlyPathsThatItWasPreparedFor) {
  PresampledEnvironment samples(EnvironmentLight(traced(), options_), leaves(), 1u << 20, 7);
  EXPECT_FALSE(samples.serves(0));
  samples.prepare(3 * PresampledEnvironment::kPathsASet);
  EXPECT_TRUE(samples.serves(3 * PresampledEnvironment::kPathsASet - 1));
  EXPECT_FALSE(samples.serves(3 * PresampledEnvironment::kPathsASet));
  samples.prepare(2 * PresampledEnvironment::kMostPaths);
  EXPECT_TRUE(samples.serves(PresampledEnvironment::kMostPaths - 1));
  EXPECT_FALSE(samples.serves(PresampledEnvironment::kMostPaths));
}

TEST_F(PresampledEnvironmentTest, IntegratesTheSky) {
  const EnvironmentLight light(traced(), options_);
  PresampledEnvironment samples(light, leaves(), 1u << 20, 3);
  constexpr int kSets = static_cast<int>(PresampledEnvironment::kMostPaths / PresampledEnvironment::kPathsASet);
  samples.prepare(PresampledEnvironment::kMostPaths + 1);
  constexpr int kSide = PresampledEnvironment::kMostSide;
  double sum = 0.0;
  for (std::uint32_t set = 0; set < kSets; ++set)
    for (int leaf = 0; leaf < leaves(); ++leaf)
      for (int i = 0; i < kSide * kSide; ++i) {
        const glm::vec2 within((static_cast<float>(i % kSide) + 0.5f) / kSide,
                               (static_cast<float>(i / kSide) + 0.5f) / kSide);
        const PresampledDirection& s = samples.at(set * PresampledEnvironment::kPathsASet, leaf, within);
        if (s.density > 0.0f)
          sum += static_cast<double>(traced().partition->probability(leaf)) * s.radiance.y / s.density;
      }
  const double mean = sum / (kSide * kSide * kSets);
  // The same by a fine grid of directions, uniform in longitude and in the sine of the latitude.
  double exact = 0.0;
  constexpr int kRows = 1024, kColumns = 2048;
  for (int y = 0; y < kRows; ++y)
    for (int x = 0; x < kColumns; ++x) {
      const double height = 1.0 - 2.0 * (y + 0.5) / kRows, longitude = 2.0 * std::numbers::pi * (x + 0.5) / kColumns;
      const double r = std::sqrt(1.0 - height * height);
      exact += light.radiance_and_density(glm::vec3(std::sin(longitude) * r, height, std::cos(longitude) * r)).y;
    }
  exact *= 4.0 * std::numbers::pi / (kRows * kColumns);
  EXPECT_NEAR(mean / exact, 1.0, 2e-3);
}

TEST_F(PresampledEnvironmentTest, FewPixelsGetFewDirectionsAndLaterPathsOthers) {
  const EnvironmentLight light(traced(), options_);
  PresampledEnvironment few(light, leaves(), 64, 3), again(light, leaves(), 64, 3);
  few.prepare(2 * PresampledEnvironment::kPathsASet);
  again.prepare(1);
  again.prepare(2 * PresampledEnvironment::kPathsASet);
  // Two numbers in the same eighth map to the same direction of the first set.
  EXPECT_EQ(few.at(0, 0, {0.01f, 0.01f}).direction, few.at(63, 0, {0.12f, 0.1f}).direction);
  EXPECT_NE(few.at(0, 0, {0.01f, 0.01f}).direction, few.at(0, 0, {0.13f, 0.01f}).direction);
  EXPECT_NE(few.at(64, 0, {0.01f, 0.01f}).direction, few.at(64, 0, {0.1f, 0.01f}).direction);
  for (const std::uint32_t path : {0u, 64u})
    for (const float u : {0.1f, 0.6f})
      EXPECT_EQ(few.at(path, 1, {u, u}).direction, again.at(path, 1, {u, u}).direction);
}

}  // namespace
}  // namespace maquette
