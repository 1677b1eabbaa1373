// Sampling of the sky by surfaces, against sums over the sky in double.
#include "render/reference/light_guide.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <random>

#include "render/reference/light_sampling.h"
#include "render/reference/path_sampler.h"
#include "render/reference/path_scene.h"
#include "render/reference/presampled_environment.h"
#include "render/reference/scattering.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

class LightGuideTest : public testing::Test {
 protected:
  LightGuideTest() { options_.env_rotation_rad = 0.8f; }
  const EnvironmentPartition& partition() const { return *scene_->environment.partition; }

  /// As after many rays, where all rays to some leaves were blocked and the others had random transmittances.
  void teach(std::uint32_t cell) {
    for (int leaf = 0; leaf < partition().leaf_count(); ++leaf)
      for (int ray = 0; ray < 40; ++ray) guide_.record(cell, leaf, leaf % 3 == 0 ? 0.0f : uniform_(random_));
    guide_.learn();
  }
  glm::vec3 random_normal() {
    const glm::vec3 v(uniform_(random_) - 0.5f, uniform_(random_) - 0.5f, uniform_(random_) - 0.5f);
    return glm::length(v) > 1e-3f ? glm::normalize(v) : glm::vec3(0.0f, 1.0f, 0.0f);
  }

  std::mt19937 random_{5};
  std::uniform_real_distribution<float> uniform_{0.0f, 0x1.fffffep-1f};
  std::shared_ptr<const PathScene> scene_ = build_path_scene(
      {.scene = test::sphere_of(Material()), .environment = test::sky_with_lamp(glm::vec3(1.0f), glm::vec3(1e4f))});
  PathOptions options_;
  LightGuide guide_{*scene_->environment.partition, HashGrid(glm::vec3(0.0f), 1.0f)};
};

TEST_F(LightGuideTest, ChoosesLeavesByTheirProbability) {
  teach(17);
  for (int round = 0; round < 50; ++round) {
    LeafShares shares;
    guide_.compute_shares(17, random_normal(), &shares);
    std::vector<double> before{0.0};
    for (int leaf = 0; leaf < partition().leaf_count(); ++leaf)
      before.push_back(before.back() + static_cast<double>(shares.probability(leaf)));
    ASSERT_NEAR(before.back(), 1.0, 1e-5);
    for (int k = 0; k < 2000; ++k) {
      const float u =
          k < 4 ? std::array{0.0f, 0x1p-24f, 0.5f, 0x1.fffffep-1f}[static_cast<std::size_t>(k)] : uniform_(random_);
      const LeafShares::Choice c = shares.choose_leaf(u);
      ASSERT_GE(c.leaf, 0);
      ASSERT_LT(c.leaf, partition().leaf_count());
      ASSERT_GT(c.probability, 0.0f);
      ASSERT_EQ(c.probability, shares.probability(c.leaf));
      ASSERT_EQ(guide_.gain(c), guide_.gain(shares, c.leaf));
      ASSERT_GE(c.within, 0.0f);
      ASSERT_LT(c.within, 1.0f);
      const auto i = static_cast<std::size_t>(c.leaf);
      ASSERT_NEAR(before[i] + (before[i + 1] - before[i]) * static_cast<double>(c.within), static_cast<double>(u),
                  2e-5);
    }
  }
}

/// Sums are rounded at the end of a block whose last leaves are dark, and at the end of all. In every other round the
/// sums of the blocks are added in pairs, and may decrease by a rounding error where a block is dark.
TEST(LeafShares, NeverChoosesDarkLeaves) {
  std::mt19937 random(8);
  std::uniform_real_distribution<float> uniform(0.0f, 0x1.fffffep-1f);
  for (int round = 0; round < 2000; ++round) {
    LeafShares shares{};
    constexpr int kLeaves = EnvironmentPartition::kMostLeaves;
    const float lit = std::array{0.05f, 0.3f, 0.9f}[static_cast<std::size_t>(round % 3)];
    for (int block = 0; block < LeafShares::kBlocks; ++block) {
      float inside = 0.0f;
      for (int i = 0; i < LeafShares::kBlock; ++i) {
        const bool lamp = uniform(random) < lit || block * LeafShares::kBlock + i == round % kLeaves;
        if (lamp) inside += std::exp2(-20.0f * uniform(random));
        shares.cumulative[LeafShares::index_of(block * LeafShares::kBlock + i) + LeafShares::kBlocks] = inside;
      }
      shares.begins[static_cast<std::size_t>(block) + 1] = inside;
    }
    if (round % 2 == 0)
      std::partial_sum(shares.begins.begin(), shares.begins.end(), shares.begins.begin());
    else
      for (std::size_t step = 1; step < LeafShares::kBlocks; step *= 2)
        for (std::size_t i = LeafShares::kBlocks; i > step; --i) shares.begins[i] += shares.begins[i - step];
    for (std::size_t k = 0; k < 100 + LeafShares::kBlocks; ++k) {
      float u =
          k < LeafShares::kBlocks ? std::min(shares.begins[k + 1] / shares.sum(), 0x1.fffffep-1f) : uniform(random);
      if (k % 2 == 1) u = std::nextafter(u, 0.0f);
      const LeafShares::Choice c = shares.choose_leaf(u);
      ASSERT_GT(c.probability, 0.0f) << round << " " << k;
      ASSERT_EQ(c.probability, shares.probability(c.leaf)) << round << " " << k;
      ASSERT_GE(c.within, 0.0f);
      ASSERT_LT(c.within, 1.0f);
    }
  }
}

/// A leaf's mean cosine above the horizon is within what its extent allows, and every direction has a density.
TEST_F(LightGuideTest, MeanCosinesMatchTheLeaves) {
  int below = 0, cut = 0;
  for (int round = 0; round < 40; ++round) {
    const glm::vec3 normal = random_normal();
    for (int leaf = 0; leaf < partition().leaf_count(); ++leaf) {
      const glm::vec4 axis = partition().axis_and_extent(leaf);
      double mean = 0.0, highest = -1.0;
      constexpr int kDraws = 64;
      for (int k = 0; k < kDraws; ++k) {
        const EnvironmentPoint point = partition().sample(scene_->environment.tables, leaf,
                                                          static_cast<double>(uniform_(random_)), (k + 0.5) / kDraws);
        const double cosine = static_cast<double>(glm::dot(partition().direction(point), normal));
        mean += std::max(cosine, 0.0) / kDraws;
        highest = std::max(highest, cosine);
        ASSERT_LE(std::abs(cosine - static_cast<double>(glm::dot(glm::vec3(axis), normal))), axis.w + 1e-3);
      }
      const auto facing = static_cast<double>(guide_.facing(leaf, normal)), extent = static_cast<double>(axis.w);
      ASSERT_GT(facing, 0.0);
      ASSERT_NEAR(facing, mean, 1.001 * extent + 1e-3);
      if (highest < -extent) {
        ASSERT_LT(facing, 0.03 * std::max(extent, 1e-3)) << leaf;
      }
      below += highest < -extent ? 1 : 0;
      cut += highest > 0.0 && glm::dot(glm::vec3(axis), normal) < axis.w ? 1 : 0;
    }
  }
  EXPECT_GT(below, 100);
  EXPECT_GT(cut, 100);
}

/// Irradiance of a surface by its samples, for any learned visibility, against the sum over the map's texels: by plain
/// importance, by a guide, and by a guide with presampled directions.
TEST_F(LightGuideTest, SamplesAreUnbiasedWithTheStatedDensity) {
  teach(3);
  const EnvironmentLight plain(scene_->environment, options_);
  PresampledEnvironment samples(plain, partition().leaf_count(), 1u << 20, 7);
  samples.prepare(1);
  const EnvironmentLight guided(scene_->environment, options_, &guide_),
      sampled(scene_->environment, options_, &guide_, &samples);
  for (const glm::vec3& normal : {glm::vec3(0.0f, 1.0f, 0.0f), glm::normalize(glm::vec3(0.3f, -0.8f, 0.5f)),
                                  glm::normalize(glm::vec3(-1.0f, 0.02f, 0.1f))}) {
    LeafShares leaf_shares;
    guided.compute_shares(3, normal, &leaf_shares);
    double expected = 0.0;
    constexpr int kFine = 2048;
    for (int y = 0; y < kFine / 2; ++y)
      for (int x = 0; x < kFine; ++x) {
        const glm::vec3 direction =
            shared::direction_from_latlong_uv((glm::vec2(x, y) + 0.5f) / glm::vec2(kFine, kFine / 2));
        const double solid = 2.0 * 9.8696044 / (kFine / 2.0 * kFine) *
                             std::sqrt(std::max(0.0, 1.0 - std::pow(static_cast<double>(direction.y), 2.0)));
        if (const float cosine = glm::dot(direction, normal); cosine > 0.0f)
          expected += static_cast<double>(cosine * plain.radiance_and_density(direction).x) * solid;
      }
    for (const EnvironmentLight* light : {&plain, &guided, &sampled}) {
      const LeafShares* shares = light == &plain ? nullptr : &leaf_shares;
      double drawn = 0.0;
      int compared = 0, alike = 0;
      constexpr std::uint32_t kDraws = 1u << 16;
      std::array<EnvironmentLight::Choice, 4> choices;
      for (std::uint32_t k = 0; k < kDraws; ++k) {
        if (k % choices.size() == 0) {
          PathSampler::Pairs numbers;
          for (std::uint32_t i = 0; i < choices.size(); ++i) numbers.index[i] = k + i;
          PathSampler::draw(9, &numbers);
          light->choose_directions(numbers, shares ? 3 : LightGuide::kNoCell, shares, 0, choices);
        }
        LightDraw draw;
        light->draw_chosen(choices[k % choices.size()], &draw);
        ASSERT_EQ(draw.texel < 0, light == &sampled);
        if (draw.texel >= 0) light->fill(&draw, shares);
        ASSERT_GT(draw.pdf, 0.0f);
        drawn += std::max(glm::dot(draw.direction, normal), 0.0f) * draw.radiance.x / draw.pdf / kDraws;
        // At a leaf's edge a direction may round to the neighbour.
        const float told = light->radiance_and_density(draw.direction, shares).w;
        ++compared;
        alike += std::abs(told - draw.pdf) < 0.01f * draw.pdf ? 1 : 0;
      }
      EXPECT_GT(alike, compared * 98 / 100);
      EXPECT_NEAR(drawn / expected, 1.0, 0.005) << normal.x << (shares ? " guided " : " plain ") << (light == &sampled);
    }
  }
}

TEST(HashGrid, FloorsAndLevelsMatchTheLibrary) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> exponent(-30.0f, 30.0f), uniform(-1.0f, 1.0f);
  for (int i = 0; i < 20000; ++i) {
    const float v = uniform(random) * std::exp2(exponent(random));
    ASSERT_EQ(HashGrid::whole_below(v), static_cast<std::int32_t>(std::floor(v))) << v;
    const auto whole = static_cast<float>(i - 10000);
    ASSERT_EQ(HashGrid::whole_below(whole), i - 10000);
  }
  EXPECT_EQ(HashGrid::whole_below(-0.0f), 0);
  EXPECT_EQ(HashGrid::whole_below(1e30f), 2000000000);
  EXPECT_EQ(HashGrid::whole_below(-1e30f), -2000000000);
  const HashGrid grid(glm::vec3(0.0f), 5.0f);
  for (int i = 0; i < 20000; ++i) {
    const double distance = std::exp2(static_cast<double>(exponent(random)));
    const double level = std::log2(std::max(0.12 * distance / 0.005, 1.0));
    if (std::abs(level - std::round(level)) < 1e-5) continue;  // where rounding decides
    ASSERT_EQ(grid.level({0.0f, static_cast<float>(distance), 0.0f}), std::min(static_cast<int>(level), 20))
        << distance;
  }
}

SurfacePoint surface_of(const TracedMaterial& material, const shared::AnalyticMaterial& analytic, const glm::vec3& wo,
                        const glm::vec3& lobe_weights) {
  SurfacePoint p;
  p.material = &material;
  p.analytic = analytic;
  p.wo = wo;
  p.lobe_weights = lobe_weights;
  return p;
}

/// Closed form: the cosine over the hemisphere is pi, and its square 2 pi / 3.
TEST(DrawScattering, AllLobesTogetherHaveTheStatedDensity) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> uniform(0.0f, 1.0f);
  const TracedMaterial material;
  for (std::uint32_t trial = 0; trial < 40; ++trial) {
    const auto analytic =
        shared::make_analytic(glm::vec3(0.5f), 0.0f, 0.3f + 0.7f * uniform(random), 1.5f, 1.0f, glm::vec3(1.0f), 1.0f,
                              0.3f + 0.7f * uniform(random), glm::vec3(0.0f), 0.0f);
    // Some without a coat, without a base lobe, or with shares that round to 0.
    glm::vec3 weights(0.2f + uniform(random), trial % 4 == 1 ? 0.0f : uniform(random),
                      trial % 4 == 2 ? 0.0f : uniform(random));
    if (trial % 4 == 3) weights.y *= 1e-8f;
    weights /= weights.x + weights.y + weights.z;
    const float z = 0.02f + 0.98f * uniform(random);
    const SurfacePoint p = surface_of(material, analytic, {std::sqrt(1.0f - z * z), 0.0f, z}, weights);
    constexpr std::uint32_t kPoints = 1u << 14;
    double first = 0.0, second = 0.0;
    for (std::uint32_t i = 0; i < kPoints; ++i) {
      const DrawnDirection d = draw_scattering(p, choose_scattering(p, PathSampler{trial, i}.pair(0)));
      if (!(d.pdf > 0.0f)) continue;
      ASSERT_FLOAT_EQ(d.pdf, scattering_pdf(p, d.wi));
      first += static_cast<double>(d.wi.z) / d.pdf / kPoints;
      second += static_cast<double>(d.wi.z) * d.wi.z / d.pdf / kPoints;
    }
    EXPECT_NEAR(first / std::numbers::pi, 1.0, 0.01) << trial;
    EXPECT_NEAR(second * 1.5 / std::numbers::pi, 1.0, 0.01) << trial;
  }
}

/// Half of the 256 points of a sequence lie in one half of the square, and one in each cell of 8 x 16 cells there.
TEST(DrawScattering, PointsAreWellDistributedInEachLobe) {
  const TracedMaterial material;
  const auto analytic = shared::make_analytic(glm::vec3(0.5f), 0.0f, 0.5f, 1.5f, 1.0f, glm::vec3(1.0f), 0.0f, 0.0f,
                                              glm::vec3(0.0f), 0.0f);
  const SurfacePoint p = surface_of(material, analytic, {0.6f, 0.0f, 0.8f}, {0.5f, 0.5f, 0.0f});
  for (std::uint32_t seed = 0; seed < 8; ++seed) {
    std::array<int, 128> counts{};
    for (std::uint32_t i = 0; i < 256; ++i) {
      const ScatteringChoice choice = choose_scattering(p, PathSampler{seed, i}.pair(3));
      if (choice.u.x >= 0.5f) continue;
      const glm::vec3 wi = draw_scattering(p, choice).wi;  // of the Lambert lobe
      const float radius2 = wi.x * wi.x + wi.y * wi.y;
      const float azimuth = std::atan2(wi.y, wi.x) * 0.15915494f;
      const int column = std::min(static_cast<int>(8.0f * radius2), 7);
      const int row = std::min(static_cast<int>(16.0f * (azimuth < 0.0f ? azimuth + 1.0f : azimuth)), 15);
      ++counts[static_cast<std::size_t>(16 * column + row)];
    }
    for (const int count : counts) EXPECT_EQ(count, 1) << seed;
  }
}

TEST(OffsetFromSurface, StepsToTheNextFloat) {
  constexpr float kLargest = std::numeric_limits<float>::max();
  for (const float v : {0.0f, -0.0f, 1.0f, -1.0f, 0.1f, -0.1f, 1e-45f, -1e-45f, 1.17549435e-38f, -1.17549435e-38f,
                        3e38f, -3e38f, 65536.0f, -65536.0f})
    for (const float normal : {1.0f, -1.0f}) {
      const glm::vec3 moved = offset_from_surface(glm::vec3(v, 2.0f, v), glm::vec3(0.0f), {0.0f, 0.0f, normal});
      EXPECT_EQ(moved.x, v);
      EXPECT_EQ(moved.y, 2.0f);
      EXPECT_EQ(moved.z, std::nextafter(v, normal * kLargest)) << v << " " << normal;
    }
}

}  // namespace
}  // namespace maquette
