// Chi-square tests of the samplers for analytic lobes, the environment, and lights. Measured tables have a test of
// their own.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <random>
#include <tuple>

#include "render/environment/environment_tables.h"
#include "render/environment/texel_cell.h"
#include "render/lights/light_list.h"
#include "render/reference/scattering.h"
#include "scenes/angles.h"
#include "tests/support/chi_square.h"

namespace {

using namespace maquette;

namespace sampled {
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
using namespace glm;
// each needs those before it
// clang-format off
#include "shared/constants.glsl"
#include "shared/surface_geometry.glsl"
#include "shared/analytic.glsl"
// clang-format on
#pragma GCC diagnostic pop
}  // namespace sampled

/// See brdf_chi_square_test.cpp.
constexpr double kLeastP = 1e-7;

/// Bins of the half vector: logarithm of the tangent of theta_h by azimuth from the plane of view.
struct HalfBins {
  static constexpr int kTangents = 40, kAzimuths = 12, kInner = 16;
  static constexpr double kLow = -12.0, kHigh = 7.0;
  static std::size_t index(double log_tangent, double phi) {
    const double i = std::clamp((log_tangent - kLow) / (kHigh - kLow) * kTangents, 0.0, kTangents - 1.0);
    const double j = std::clamp((phi + std::numbers::pi) / (2.0 * std::numbers::pi) * kAzimuths, 0.0, kAzimuths - 1.0);
    return static_cast<std::size_t>(i) * kAzimuths + static_cast<std::size_t>(j);
  }
};

struct AnalyticCase {
  std::string name;
  sampled::AnalyticMaterial material{};
};

std::vector<AnalyticCase> analytic_cases() {
  const auto make = [](float metallic, float roughness, float coat, float coat_roughness, float sheen) {
    return sampled::make_analytic(glm::vec3(0.6f, 0.3f, 0.1f), metallic, roughness, 1.5f, 1.0f, glm::vec3(1.0f), coat,
                                  coat_roughness, glm::vec3(sheen), 0.4f);
  };
  sampled::AnalyticMaterial brushed = sampled::with_anisotropy(make(1.0f, 0.2f, 0.0f, 0.0f, 0.0f), 0.8f);
  sampled::AnalyticMaterial tilted_coat = make(0.0f, 0.6f, 1.0f, 0.2f, 0.0f);
  tilted_coat.coat_normal = glm::normalize(glm::vec3(0.2f, -0.1f, 1.0f));
  return {{"brushed metal", brushed},
          {"coat with a normal of its own", tilted_coat},
          {"matte", make(0.0f, 1.0f, 0.0f, 0.0f, 0.0f)},
          {"plastic", make(0.0f, 0.3f, 0.0f, 0.0f, 0.0f)},
          {"rough metal", make(1.0f, 0.7f, 0.0f, 0.0f, 0.0f)},
          {"mirror", make(1.0f, 0.0f, 0.0f, 0.0f, 0.0f)},
          {"coated", make(0.5f, 0.5f, 1.0f, 0.05f, 0.0f)},
          {"cloth", make(0.0f, 0.9f, 0.0f, 0.0f, 1.0f)}};
}

/// Light direction of a half vector, in the frame whose x is the azimuth of the view.
glm::dvec3 light_of(const glm::dvec3& wo, double tangent, double phi) {
  const double c = 1.0 / std::sqrt(1.0 + tangent * tangent), s = tangent * c;
  const glm::dvec3 h(s * std::cos(phi), s * std::sin(phi), c);
  return 2.0 * glm::dot(wo, h) * h - wo;
}

test::ChiSquare test_analytic(const sampled::AnalyticMaterial& m, double theta, std::uint32_t seed,
                              std::size_t samples) {
  const glm::vec3 view(static_cast<float>(std::sin(theta)), 0.0f, static_cast<float>(std::cos(theta)));
  const glm::dvec3 wo(view);
  const glm::vec3 weights = sampled::analytic_lobe_weights(m, view);
  constexpr int kInner = HalfBins::kInner;
  std::vector<double> expected(HalfBins::kTangents * HalfBins::kAzimuths + 1, 0.0), counted(expected.size(), 0.0);
  constexpr int kFineT = HalfBins::kTangents * kInner, kFineP = HalfBins::kAzimuths * kInner;
  for (int i = 0; i < kFineT; ++i) {
    const double step = (HalfBins::kHigh - HalfBins::kLow) / kFineT, u = HalfBins::kLow + (i + 0.5) * step;
    const double tangent = std::exp(u), c2 = 1.0 / (1.0 + tangent * tangent);
    for (int j = 0; j < kFineP; ++j) {
      const double phi = -std::numbers::pi + 2.0 * std::numbers::pi * (j + 0.5) / kFineP;
      const glm::dvec3 wi = light_of(wo, tangent, phi);
      const double projection = 0.5 * glm::length(wi + wo);
      if (wi.z <= 0.0 || glm::dot(wi + wo, glm::dvec3(0.0, 0.0, 1.0)) <= 0.0) continue;
      const double solid_angle =
          tangent * std::sqrt(c2) * tangent * c2 * step * 2.0 * std::numbers::pi / kFineP;  // sin dtheta dphi
      expected[HalfBins::index(u, phi)] += static_cast<double>(samples) * solid_angle * 4.0 * projection *
                                           static_cast<double>(sampled::analytic_pdf(m, weights, glm::vec3(wi), view));
    }
  }
  double inside = 0.0;
  for (const double e : expected) inside += e;
  expected.back() = std::max(static_cast<double>(samples) - inside, 0.0);
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (std::size_t s = 0; s < samples; ++s) {
    const float u1 = unit(random), u2 = unit(random);
    const LobeChoice chosen = choose_lobe(weights, u1);
    const glm::dvec3 wi(sampled::sample_analytic(m, chosen.lobe, view, chosen.within, u2));
    const glm::dvec3 sum = wi + wo;
    if (!(wi.z > 0.0)) {
      counted.back() += 1.0;
      continue;
    }
    counted[HalfBins::index(std::log(std::max(std::hypot(sum.x, sum.y), 1e-300) / sum.z), std::atan2(sum.y, sum.x))] +=
        1.0;
  }
  // Directions are floats: near the horizon the tangent of theta_h is accurate to 6e-8 / cos(theta_o), and a mirror's
  // lobe is 1e-3 wide.
  return test::chi_square(expected, counted, 20.0, theta > 1.565 ? 0.03 : 0.0);
}

TEST(AnalyticChiSquare, EveryLobeFromNormalToGrazing) {
  std::mt19937 random(test::test_seed(3));
  for (const AnalyticCase& c : analytic_cases()) {
    for (const double degrees : {0.0, 5.0, 30.0, 60.0, 80.0, 88.0, 89.9}) {
      const auto result =
          test_analytic(c.material, radians(degrees), static_cast<std::uint32_t>(random()), test::test_samples(20000));
      EXPECT_GT(result.p, kLeastP) << c.name << " at " << degrees << " degrees, statistic " << result.statistic
                                   << " of " << result.freedom;
    }
  }
}

Environment make_environment(int width, int height, const std::function<double(int, int)>& f) {
  Environment e;
  e.width = width;
  e.height = height;
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) e.rgb.emplace_back(static_cast<float>(f(x, y)));
  return e;
}

struct NamedEnvironment {
  std::string name;
  Environment environment;
};

std::vector<NamedEnvironment> environments() {
  std::vector<NamedEnvironment> list;
  list.push_back({"constant", make_environment(64, 32, [](int, int) { return 1.0; })});
  list.push_back({"1 x 1", make_environment(1, 1, [](int, int) { return 3.0; })});
  list.push_back({"2 x 1", make_environment(2, 1, [](int x, int) { return x ? 1.0 : 0.0; })});
  list.push_back(
      {"one hot texel", make_environment(64, 32, [](int x, int y) { return x == 17 && y == 9 ? 1e5 : 0.0; })});
  list.push_back({"hot pole", make_environment(32, 16, [](int x, int y) { return x == 3 && y == 0 ? 1e6 : 1e-3; })});
  list.push_back({"sun of 1e6 times the sky",
                  make_environment(256, 128, [](int x, int y) { return x == 40 && y == 30 ? 1e6 : 0.5 + y / 128.0; })});
  std::mt19937 random(test::test_seed(8));
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  list.push_back(
      {"noise", make_environment(48, 24, [&](int, int) { return std::pow(10.0, 6.0 * unit(random) - 3.0); })});
  list.push_back(
      {"row of black", make_environment(48, 24, [](int x, int y) { return y % 3 == 1 && x % 5 < 2 ? 1.0 : 0.0; })});
  return list;
}

double cell_solid_angle(int y, int width, int height) {
  return 2.0 * std::numbers::pi / width *
         (std::cos(std::numbers::pi * y / height) - std::cos(std::numbers::pi * (y + 1) / height));
}

/// Every lobe with a share gets a sample, and no count is off by more than these extra samples.
TEST(AnalyticLobes, CountsFollowTheShares) {
  std::mt19937 random(4);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int i = 0; i < 20000; ++i) {
    glm::vec3 weights(unit(random), unit(random), unit(random));
    for (int k = 0; k < 3; ++k) weights[k] = unit(random) < 0.3f ? 0.0f : std::pow(weights[k], 8.0f);
    const float sum = weights.x + weights.y + weights.z;
    weights = sum > 0.0f ? weights / sum : glm::vec3(1.0f, 0.0f, 0.0f);
    const int n = 8 + static_cast<int>(unit(random) * 250.0f);
    const glm::ivec3 counts = sampled::lobe_counts(weights, n);
    ASSERT_EQ(counts.x + counts.y + counts.z, n);
    for (int k = 0; k < 3; ++k) {
      ASSERT_EQ(counts[k] > 0, weights[k] > 0.0f) << k;
      ASSERT_NEAR(static_cast<float>(counts[k]), weights[k] * static_cast<float>(n), 2.001f) << k;
    }
  }
}

/// One number selects a lobe in proportion to its share, and is uniform within it.
TEST(AnalyticLobes, ChoiceRescalesItsNumberWithinTheShare) {
  const glm::vec3 weights(0.5f, 0.125f, 0.375f);
  for (const auto& [u, lobe, within] : {std::tuple{0.0f, 0, 0.0f},
                                        {0.25f, 0, 0.5f},
                                        {0.5f, 1, 0.0f},
                                        {0.5625f, 1, 0.5f},
                                        {0.625f, 2, 0.0f},
                                        {0.8125f, 2, 0.5f}}) {
    const LobeChoice chosen = choose_lobe(weights, u);
    EXPECT_EQ(chosen.lobe, lobe) << u;
    EXPECT_FLOAT_EQ(chosen.within, within) << u;
  }
  EXPECT_LT(choose_lobe(weights, 0x1.fffffep-1f).within, 1.0f);
}

/// Independent draws: every sample is the first of a run of its own.
TEST(EnvironmentChiSquare, SamplesFollowTheDensity) {
  for (const auto& [name, environment] : environments()) {
    const EnvironmentTables tables = compute_environment_tables(environment);
    const std::size_t samples = test::test_samples(40000), cells = tables.density.size();
    std::vector<double> expected(cells, 0.0), counted(cells, 0.0);
    double total = 0.0;
    for (std::size_t i = 0; i < cells; ++i) {
      const int y = static_cast<int>(i) / tables.width;
      expected[i] = static_cast<double>(tables.density[i]) * cell_solid_angle(y, tables.width, tables.height);
      total += expected[i];
      expected[i] *= static_cast<double>(samples);
    }
    EXPECT_NEAR(total, 1.0, 1e-5) << name;
    // A low-discrepancy run is more uniform than chance: the statistic is then small, never large.
    const auto list = sample_environment(environment, tables, pack_sky(environment, packing_bias(environment), 2),
                                         test::test_seed(21), samples);
    for (const EnvironmentSample& s : list) {
      const double latitude = std::asin(std::clamp(static_cast<double>(s.direction.y), -1.0, 1.0));
      const double longitude = std::atan2(static_cast<double>(s.direction.x), static_cast<double>(s.direction.z));
      const int x =
          std::clamp(static_cast<int>((std::numbers::pi - longitude) / (2.0 * std::numbers::pi) * tables.width), 0,
                     tables.width - 1);
      const int y =
          std::clamp(static_cast<int>((0.5 - latitude / std::numbers::pi) * tables.height), 0, tables.height - 1);
      counted[static_cast<std::size_t>(y * tables.width + x)] += 1.0;
    }
    // Directions are floats: at a cell's edge one may fall into the neighbour.
    double misplaced = 0.0;
    for (std::size_t i = 0; i < cells; ++i)
      if (expected[i] == 0.0) misplaced += std::exchange(counted[i], 0.0);
    EXPECT_LE(misplaced, 1e-3 * static_cast<double>(samples)) << name;
    const auto result = test::chi_square(expected, counted);
    EXPECT_GT(result.p, kLeastP) << name << ", statistic " << result.statistic << " of " << result.freedom;
  }
}

/// The exact probabilities of the cumulative tables, cell by cell, against the density that estimators divide by,
/// without any sampling.
TEST(EnvironmentChiSquare, CumulativeTablesMatchTheDensity) {
  for (const auto& [name, environment] : environments()) {
    const EnvironmentTables tables = compute_environment_tables(environment);
    const auto width = static_cast<std::size_t>(tables.width), height = static_cast<std::size_t>(tables.height);
    double worst = 0.0, variation = 0.0, lost = 0.0;
    for (std::size_t y = 0; y < height; ++y) {
      const double row = static_cast<double>(tables.marginal_cdf[y + 1]) - static_cast<double>(tables.marginal_cdf[y]);
      const double solid_angle = cell_solid_angle(static_cast<int>(y), tables.width, tables.height);
      for (std::size_t x = 0; x < width; ++x) {
        const float* cdf = &tables.conditional_cdf[y * (width + 1) + x];
        const double drawn = row * (static_cast<double>(cdf[1]) - static_cast<double>(cdf[0]));
        const double said = static_cast<double>(tables.density[y * width + x]) * solid_angle;
        variation += 0.5 * std::abs(drawn - said);
        if (said > 0.0) worst = std::max(worst, std::abs(drawn - said) / said);
        if (drawn == 0.0) lost += said;
      }
    }
    EXPECT_LT(variation, 1e-6) << name;
    EXPECT_EQ(lost, 0.0) << name;
    EXPECT_LT(worst, 1e-6) << name;
  }
}

/// Bilinear importance by its definition, x and y from the corner of the middle texel of 3 x 3.
double bilinear(const std::array<double, 9>& texels, double x, double y) {
  double sum = 0.0;
  for (int j = 0; j < 3; ++j)
    for (int i = 0; i < 3; ++i)
      sum += texels[static_cast<std::size_t>(3 * j + i)] * std::max(1.0 - std::abs(x - (i - 0.5)), 0.0) *
             std::max(1.0 - std::abs(y - (j - 0.5)), 0.0);
  return sum;
}

TEST(EnvironmentChiSquare, PositionsWithinACellFollowBilinearLight) {
  constexpr int kSide = 8;
  std::mt19937 random(test::test_seed(31));
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int round = 0; round < 12; ++round) {
    std::array<double, 9> texels{};
    for (double& t : texels) t = round % 3 == 0 ? unit(random) : std::pow(10.0, 8.0 * unit(random) - 4.0);
    if (round == 1) texels = {0, 0, 0, 0, 1, 0, 0, 0, 0};
    if (round == 2) texels = {0, 0, 0, 0, 0, 0, 0, 0, 1e6};
    if (round == 4) texels = {1e30, 0, 0, 0, 0, 0, 0, 0, 1e30};
    const TexelCell cell([&](int dx, int dy) { return texels[static_cast<std::size_t>(3 * (dy + 1) + dx + 1)]; });
    const std::size_t samples = test::test_samples(40000);
    std::vector<double> expected(kSide * kSide, 0.0), counted(kSide * kSide, 0.0);
    // Bilinear pieces: the middle of each part is its mean.
    double mean = 0.0;
    for (int k = 0; k < kSide * kSide; ++k) {
      const double x = (k % kSide + 0.5) / kSide, y = (static_cast<double>(k / kSide) + 0.5) / kSide;
      const double exact = bilinear(texels, x, y);
      EXPECT_NEAR(cell.at({x, y}), exact, 1e-12 * exact);
      expected[static_cast<std::size_t>(k)] = exact;
      mean += exact / (kSide * kSide);
    }
    EXPECT_NEAR(cell.mean(), mean, 1e-12 * mean);
    for (double& e : expected) e *= static_cast<double>(samples) / (mean * kSide * kSide);
    for (std::size_t i = 0; i < samples; ++i) {
      const glm::dvec2 p = cell.warp({unit(random), unit(random)});
      ASSERT_TRUE(p.x >= 0.0 && p.x <= 1.0 && p.y >= 0.0 && p.y <= 1.0) << p.x << ' ' << p.y;
      counted[static_cast<std::size_t>(std::min(static_cast<int>(p.y * kSide), kSide - 1) * kSide +
                                       std::min(static_cast<int>(p.x * kSide), kSide - 1))] += 1.0;
    }
    const auto result = test::chi_square(expected, counted);
    EXPECT_GT(result.p, kLeastP) << round << ", statistic " << result.statistic << " of " << result.freedom;
  }
  // No light: any position in the cell is correct.
  const glm::dvec2 dark = TexelCell([](int, int) { return 0.0; }).warp({0.25, 0.75});
  EXPECT_EQ(dark.x, 0.25);
  EXPECT_EQ(dark.y, 0.75);
}

TEST(LightChiSquare, PointsOnATriangleAreUniform) {
  constexpr int kSide = 12;
  std::vector<double> expected(kSide * kSide, 0.0), counted(expected.size(), 0.0);
  const std::size_t samples = test::test_samples(100000);
  std::mt19937 random(test::test_seed(4));
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int i = 0; i < kSide; ++i)
    for (int j = 0; i + j < kSide; ++j)
      expected[static_cast<std::size_t>(i * kSide + j)] =
          static_cast<double>(samples) * (i + j + 1 < kSide ? 2.0 : 1.0) / (kSide * kSide);
  for (std::size_t s = 0; s < samples; ++s) {
    const float a = unit(random);
    const glm::vec2 uv = shared::light_triangle_uv({a, unit(random)});
    ASSERT_LE(uv.x + uv.y, 1.000001f);
    const int i = std::min(static_cast<int>(uv.x * kSide), kSide - 1),
              j = std::min(static_cast<int>(uv.y * kSide), kSide - 1 - i);
    counted[static_cast<std::size_t>(i * kSide + j)] += 1.0;
  }
  const auto result = test::chi_square(expected, counted);
  EXPECT_GT(result.p, kLeastP) << result.statistic << " of " << result.freedom;
  EXPECT_EQ(result.outside, 0);
}

/// The shader draws u as an integer multiple of 2^-24: each light's true probability is exactly the count of those
/// below its entry.
TEST(LightChiSquare, EachLightIsChosenByItsProbability) {
  Scene scene;
  const auto add = [&](PunctualLight::Kind kind, float intensity) {
    PunctualLight light;
    light.kind = kind;
    light.intensity = intensity;
    Node node;
    node.light = static_cast<int>(scene.lights.size());
    scene.lights.push_back(light);
    scene.nodes.push_back(node);
    scene.roots.push_back(static_cast<int>(scene.nodes.size()) - 1);
  };
  add(PunctualLight::Kind::point, 1e5f);
  std::mt19937 random(test::test_seed(6));
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int i = 0; i < 3000; ++i) add(PunctualLight::Kind::point, std::pow(10.0f, 5.0f * unit(random) - 3.0f));
  const LightList list = build_light_list(scene, flatten(scene), -1);
  ASSERT_EQ(list.lights.size(), 3001u);
  double before = 0.0, sum = 0.0;
  for (const LightRecord& light : list.lights) {
    const double below = std::ceil(static_cast<double>(light.cdf) * 0x1p24);
    const double drawn = (below - before) * 0x1p-24;
    const double said = static_cast<double>(light.selection_pdf);
    // It is drawn, with exactly the probability that its contribution is divided by.
    EXPECT_GE(said, 0x1p-24);
    EXPECT_EQ(drawn, said);
    sum += said;
    before = below;
  }
  EXPECT_EQ(before, 0x1p24);
  EXPECT_NEAR(sum, 1.0, 1e-5);
}

}  // namespace
