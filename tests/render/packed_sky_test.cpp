#include "render/environment/packed_sky.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "render/environment/environment_tables.h"

namespace maquette {
namespace {

Environment noisy_map(int width, int height, double spread, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::lognormal_distribution<float> value(0.0f, static_cast<float>(spread));
  Environment e;
  e.width = width;
  e.height = height;
  for (int i = 0; i < width * height; ++i) e.rgb.emplace_back(value(random), value(random), value(random));
  return e;
}

/// Expected value of the shader's lookup over its random selection, in double.
glm::dvec3 mean_of_nodes(const PackedSky& sky, double u, double v) {
  const double x = u * sky.columns - static_cast<double>(sky.offset),
               y = v * sky.spans - static_cast<double>(sky.offset);
  const double a = x - std::floor(x), b = y - std::floor(y);
  glm::dvec3 sum(0.0);
  for (int k = 0; k < 4; ++k) {
    const double weight = (k & 1 ? a : 1.0 - a) * (k >> 1 ? b : 1.0 - b);
    sum += weight *
           glm::dvec3(sky.at(static_cast<int>(std::floor(x)) + (k & 1), static_cast<int>(std::floor(y)) + (k >> 1)));
  }
  return sum;
}

TEST(PackedSky, NodesHoldTheBilinearMapAtEverySpacing) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> uniform;
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 1}, {1, 3}, {7, 5}, {32, 16}}) {
    const Environment e = noisy_map(width, height, 1.0, static_cast<std::uint32_t>(width * 31 + height));
    for (const int refinement : {1, 2, 4}) {
      const PackedSky sky = pack_sky(e, packing_bias(e), refinement);
      ASSERT_EQ(sky.words.size(), static_cast<std::size_t>(sky.columns * (sky.last_row + 1)));
      for (int i = 0; i < 2000; ++i) {
        // Every eighth point is on an edge or a centre of the map, poles and seam included.
        double u = uniform(random), v = uniform(random);
        if (i % 8 == 0) u = std::floor(u * 2 * width) / (2 * width);
        if (i % 8 < 2) v = std::round(v * 2 * height) / (2 * height);
        const glm::dvec3 truth = evaluate_environment(e, direction_from_latlong(u * width, v * height, width, height));
        const glm::dvec3 found = mean_of_nodes(sky, u, v);
        // Two roundings of the largest node around, and directions go through angles.
        double largest = 0.0;
        for (const glm::vec3& c : e.rgb)
          largest = std::max({largest, static_cast<double>(c.x), static_cast<double>(c.y), static_cast<double>(c.z)});
        for (int c = 0; c < 3; ++c)
          ASSERT_NEAR(found[c], truth[c], largest / 255.0)
              << width << 'x' << height << " by " << refinement << " at " << u << ' ' << v;
      }
    }
  }
}

TEST(PackedSky, CloserNodesDifferLess) {
  const Environment e = noisy_map(64, 32, 2.0, 8);
  double before = INFINITY;
  for (const int refinement : {1, 2, 4}) {
    const PackedSky sky = pack_sky(e, packing_bias(e), refinement);
    // Variance added by the selection between neighbours of a row: weights uniform in [0, 1) give a sixth of the
    // squared difference.
    double sum = 0.0;
    for (int y = 0; y <= sky.last_row; ++y)
      for (int x = 0; x < sky.columns; ++x) {
        const double d = static_cast<double>(sky.at(x + 1, y).y) - static_cast<double>(sky.at(x, y).y);
        sum += d * d / 6.0;
      }
    sum /= static_cast<double>(sky.words.size());
    EXPECT_LT(sum, before / 3.0);  // a quarter along the row
    before = sum;
  }
}

TEST(PackedSky, LampsKeepTheirPower) {
  // Lamps of four equal texels in a sky a thousand times darker: rounding all of them equally would change their power
  // by up to 1/511.
  std::mt19937 random(11);
  std::uniform_real_distribution<float> value(0.5f, 1.0f);
  double worst = 0.0;
  for (int i = 0; i < 200; ++i) {
    Environment e;
    e.width = 16;
    e.height = 8;
    e.rgb.assign(128, glm::vec3(1e-3f));
    const glm::vec3 lamp(value(random), value(random), value(random));
    for (const int texel : {51, 52, 67, 68}) e.rgb[static_cast<std::size_t>(texel)] = lamp;
    const PackedSky sky = pack_sky(e, packing_bias(e), 2);
    glm::dvec3 sum(0.0);
    for (int y = 4; y <= 12; ++y)
      for (int x = 4; x <= 12; ++x) sum += glm::dvec3(sky.at(x, y));
    // Nodes at half texels: the weights of each texel's tent sum to 2 x 2; the sky around accounts for the rest.
    const glm::dvec3 truth = 16.0 * glm::dvec3(lamp) + (81.0 - 16.0) * 1e-3;
    for (int c = 0; c < 3; ++c) worst = std::max(worst, std::abs(sum[c] / truth[c] - 1.0));
  }
  EXPECT_LT(worst, 7e-4);
}

TEST(PackedSky, RefinementKeepsTheGridBelowItsLimit) {
  Environment e;
  for (const auto& [texels, refinement] : {std::pair{100u, 4}, {400u, 2}, {401u, 1}, {1600u, 1}}) {
    e.rgb.resize(texels);
    EXPECT_EQ(sky_refinement(e, 1600), refinement) << texels;
  }
}

TEST(PackedSky, ListsOfCloserNodesSumToTheSameLight) {
  // A lamp of one texel in noise: averaged over the list, light over density is the integral, whatever the spacing.
  Environment e = noisy_map(32, 16, 0.5, 5);
  e.rgb[8 * 32 + 31] = glm::vec3(3000.0f, 2000.0f, 1000.0f);
  const EnvironmentTables tables = compute_environment_tables(e);
  for (const int refinement : {1, 2, 4}) {
    glm::dvec3 sum(0.0);
    const auto list = sample_environment(e, tables, pack_sky(e, packing_bias(e), refinement), 7, 65536);
    for (const EnvironmentSample& s : list) sum += glm::dvec3(s.radiance) / static_cast<double>(s.pdf) / 65536.0;
    glm::dvec3 truth(0.0);
    const int kSide = 512;  // midpoint rule over the map
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < 2 * kSide; ++i) {
        const double x = (i + 0.5) * 32 / (2.0 * kSide), y = (j + 0.5) * 16 / kSide;
        truth += evaluate_environment(e, direction_from_latlong(x, y, 32, 16)) *
                 std::sin(3.14159265358979 * (j + 0.5) / kSide);
      }
    truth *= 2.0 * 3.14159265358979 * 3.14159265358979 / (2.0 * kSide * kSide);
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(sum[c] / truth[c], 1.0, 2e-3) << refinement;
  }
}

// Integrals through a lobe are the same by list and by map, with and without random node selection.
TEST(PackedSky, ListsAgreeThroughALobe) {
  const Environment e = noisy_map(32, 16, 0.5, 8);
  const EnvironmentTables tables = compute_environment_tables(e);
  const auto lobe = [](const glm::dvec3& d, const glm::dvec3& axis) {
    return std::pow(std::max(0.0, glm::dot(d, axis)), 8.0);
  };
  for (const glm::dvec3& axis : {glm::dvec3(0, 1, 0), glm::dvec3(0.6, 0, 0.8), glm::dvec3(-0.48, -0.6, 0.64)}) {
    double truth = 0.0;
    constexpr int kSide = 256;
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < 2 * kSide; ++i) {
        const glm::dvec3 d = direction_from_latlong(i + 0.5, j + 0.5, 2 * kSide, kSide);
        truth += lobe(d, axis) * evaluate_environment(e, d).y * std::sin(3.14159265358979 * (j + 0.5) / kSide);
      }
    truth *= 3.14159265358979 * 3.14159265358979 / (kSide * kSide);
    for (const int refinement : {1, 2, 4}) {
      double mean = 0.0;
      for (const unsigned seed : {3u, 4u, 5u, 6u})
        for (const EnvironmentSample& s :
             sample_environment(e, tables, pack_sky(e, packing_bias(e), refinement), seed, 65536))
          mean += lobe(glm::dvec3(s.direction), axis) * static_cast<double>(s.radiance.y) / static_cast<double>(s.pdf) /
                  (4.0 * 65536.0);
      EXPECT_NEAR(mean / truth, 1.0, 5e-3) << refinement;
    }
  }
}

}  // namespace
}  // namespace maquette
