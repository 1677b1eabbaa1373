#include "render/environment/prefilter.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <functional>
#include <numbers>

namespace maquette {
namespace {

Environment make_environment(int width, const std::function<glm::dvec3(const glm::dvec3&, int, int)>& value) {
  Environment e;
  e.width = width;
  e.height = width / 2;
  for (int y = 0; y < e.height; ++y)
    for (int x = 0; x < width; ++x)
      e.rgb.emplace_back(value(direction_from_latlong(x + 0.5, y + 0.5, width, e.height), x, y));
  return e;
}

glm::dvec3 flux(const Image& map) {
  glm::dvec3 sum(0.0);
  for (int y = 0; y < map.height; ++y) {
    const double solid_angle =
        2.0 * std::numbers::pi / map.width *
        (std::cos(std::numbers::pi * y / map.height) - std::cos(std::numbers::pi * (y + 1) / map.height));
    for (int x = 0; x < map.width; ++x)
      sum += solid_angle * glm::dvec3(map.at(x, y, 0), map.at(x, y, 1), map.at(x, y, 2));
  }
  return sum;
}

/// Checks map = 1 + share * a.d for the sky 1 + a.d: a zonal kernel scales the first harmonics by its mean cosine.
void expect_first_harmonic(const Image& map, const glm::dvec3& a, double share, double tolerance) {
  for (int y = 0; y < map.height; ++y)
    for (int x = 0; x < map.width; ++x)
      ASSERT_NEAR(map.at(x, y, 1),
                  1.0 + share * glm::dot(a, direction_from_latlong(x + 0.5, y + 0.5, map.width, map.height)), tolerance)
          << map.width << ": " << x << ' ' << y;
}

const glm::dvec3 kSlope(0.5, 0.6, -0.3);
Environment sloping_sky(int width = 256) {
  return make_environment(width, [](const glm::dvec3& d, int, int) { return glm::dvec3(1.0 + glm::dot(kSlope, d)); });
}

/// Mean cosine of a kernel by quadrature in double.
double mean_cosine(const std::function<double(double)>& kernel) {
  double weighted = 0.0, total = 0.0;
  for (int i = 0; i < 200000; ++i) {
    const double theta = std::numbers::pi / 2.0 * (i + 0.5) / 200000;
    weighted += kernel(theta) * std::sin(theta) * std::cos(theta);
    total += kernel(theta) * std::sin(theta);
  }
  return weighted / total;
}

TEST(Prefilter, AConstantSkyStays) {
  const Environment e = make_environment(64, [](const glm::dvec3&, int, int) { return glm::dvec3(3.0, 2.0, 1.0); });
  std::vector<Image> maps = prefilter_ggx(e, 5);
  for (const Image& map : prefilter_sg(e, {1.0f, 30.0f, 5000.0f})) maps.push_back(map);
  maps.push_back(prefilter_diffuse(e));
  for (const Image& map : maps)
    for (int c = 0; c < 3; ++c)
      for (int i = 0; i < map.width * map.height; ++i)
        ASSERT_NEAR(map.at(i % map.width, i / map.width, c), 3.0f - static_cast<float>(c), 1e-3f);
}

TEST(Prefilter, GgxScalesTheFirstHarmonicByItsMeanCosine) {
  const std::vector<Image> maps = prefilter_ggx(sloping_sky(), 5);
  ASSERT_EQ(maps.size(), 5u);
  EXPECT_EQ(maps[0].width, 256);
  for (int i = 1; i < 5; ++i) {
    const double alpha = std::pow(i / 4.0, 2.0);
    const double share = mean_cosine([&](double theta) {
      const double c = std::cos(theta / 2.0);
      return std::cos(theta) / std::pow(c * c * (alpha * alpha - 1.0) + 1.0, 2.0);
    });
    expect_first_harmonic(maps[static_cast<std::size_t>(i)], kSlope, share, 0.016);
  }
}

TEST(Prefilter, SphericalGaussianScalesByItsClosedForm) {
  const std::vector<float> sharpness = {1.0f, 8.0f, 100.0f, 2000.0f};
  const std::vector<Image> maps = prefilter_sg(sloping_sky(), sharpness);
  for (std::size_t i = 0; i < maps.size(); ++i) {
    const double lambda = static_cast<double>(sharpness[i]);
    expect_first_harmonic(maps[i], kSlope, 1.0 / std::tanh(lambda) - 1.0 / lambda, 0.016);
  }
}

TEST(Prefilter, DiffuseIsTwoThirds) {
  // Also of many texels a cell, and of fewer than cells.
  for (const int width : {32, 256, 2048})
    expect_first_harmonic(prefilter_diffuse(sloping_sky(width)), kSlope, 2.0 / 3.0, 0.016);
}

TEST(Prefilter, AHotTexelKeepsItsEnergyAndMakesTheLobe) {
  const Environment e = make_environment(
      256, [](const glm::dvec3&, int x, int y) { return glm::dvec3(x == 100 && y == 50 ? 1e6 : 0.0); });
  const double solid_angle =
      2.0 * std::numbers::pi / 256 * (std::cos(std::numbers::pi * 50 / 128) - std::cos(std::numbers::pi * 51 / 128));
  const glm::dvec3 sun = direction_from_latlong(100.5, 50.5, 256, 128);
  for (const float lambda : {8.0f, 50.0f}) {
    const Image map = prefilter_sg(e, {lambda})[0];
    EXPECT_NEAR(flux(map).x / (1e6 * solid_angle), 1.0, 0.05) << lambda;
    const double l = static_cast<double>(lambda),
                 peak = 1e6 * solid_angle * l / (2.0 * std::numbers::pi * (1.0 - std::exp(-2.0 * l)));
    double worst = 0.0;
    for (int y = 0; y < map.height; ++y) {
      for (int x = 0; x < map.width; ++x) {
        const double cosine = glm::dot(sun, direction_from_latlong(x + 0.5, y + 0.5, map.width, map.height));
        worst = std::max(worst, std::abs(static_cast<double>(map.at(x, y)) / peak - std::exp(l * (cosine - 1.0))));
      }
    }
    EXPECT_LT(worst, 0.15) << lambda;
  }
}

TEST(Prefilter, PolesAndSeamAreSmooth) {
  // A hot cap at the pole must look the same from all longitudes, in the row next to it.
  const Environment e = make_environment(256, [](const glm::dvec3& d, int, int) {
    return glm::dvec3(d.y > 0.99 ? 100.0 : d.y < -0.99 ? 50.0 : 0.1);
  });
  for (const Image& map : prefilter_ggx(e, 4)) {
    if (map.width == 256) continue;
    for (const int y : {0, 1, map.height - 2, map.height - 1}) {
      float low = 1e30f, high = 0.0f;
      for (int x = 0; x < map.width; ++x) {
        low = std::min(low, map.at(x, y));
        high = std::max(high, map.at(x, y));
      }
      EXPECT_LT(high / low, 1.12f) << map.width << ' ' << y;
    }
  }
}

TEST(Prefilter, ExtremesAreFinite) {
  const Environment black = make_environment(32, [](const glm::dvec3&, int, int) { return glm::dvec3(0.0); });
  for (const Image& map : prefilter_ggx(black, 3))
    for (const float v : map.data) ASSERT_EQ(v, 0.0f);
  Environment one;
  one.width = one.height = 1;
  one.rgb = {glm::vec3(2.0f)};
  for (const Image& map : prefilter_ggx(one, 3))
    for (const float v : map.data) ASSERT_NEAR(v, 2.0f, 1e-4f);
}

TEST(SplitSum, FollowsItsIntegral) {
  const Image table = split_sum_table(16);
  for (const auto& [x, y] : {std::pair{3, 4}, {8, 8}, {14, 2}, {12, 15}, {1, 12}}) {
    // Brute force over the half sphere of l.
    const double nv = (x + 0.5) / 16, alpha = std::pow((y + 0.5) / 16, 2.0), a2 = alpha * alpha;
    const glm::dvec3 view(std::sqrt(1.0 - nv * nv), 0.0, nv);
    const auto g1 = [&](double c) { return 2.0 * c / (c + std::sqrt(a2 + (1.0 - a2) * c * c)); };
    double scale = 0.0, bias = 0.0;
    constexpr int kSteps = 700;
    for (int i = 0; i < kSteps; ++i) {
      for (int j = 0; j < kSteps; ++j) {
        const double nl = (i + 0.5) / kSteps, phi = 2.0 * std::numbers::pi * (j + 0.5) / kSteps;
        const glm::dvec3 l(std::sqrt(1.0 - nl * nl) * std::cos(phi), std::sqrt(1.0 - nl * nl) * std::sin(phi), nl);
        const glm::dvec3 h = glm::normalize(l + view);
        const double d = h.z * h.z * (a2 - 1.0) + 1.0, vh = glm::dot(view, h);
        const double f = a2 / (std::numbers::pi * d * d) * g1(nl) * g1(nv) / (4.0 * nl * nv) * nl * 2.0 *
                         std::numbers::pi / (kSteps * kSteps);
        const double fresnel = std::pow(1.0 - vh, 5.0);
        scale += (1.0 - fresnel) * f;
        bias += fresnel * f;
      }
    }
    EXPECT_NEAR(table.at(x, y, 0), scale, 0.01) << x << ' ' << y;
    EXPECT_NEAR(table.at(x, y, 1), bias, 0.01) << x << ' ' << y;
  }
}

TEST(Prefilter, TheCacheGivesTheSameMaps) {
  const auto folder = std::filesystem::temp_directory_path() / ("maquette_prefilter_" + std::to_string(::getpid()));
  const char* before = std::getenv("MAQUETTE_CACHE");
  const std::string saved = before ? before : "";
  ::setenv("MAQUETTE_CACHE", folder.c_str(), 1);
  Environment e = sloping_sky();
  const std::vector<Image> first = prefilter_ggx(e, 3), second = prefilter_ggx(e, 3);
  EXPECT_FALSE(std::filesystem::is_empty(folder));
  ASSERT_EQ(first.size(), second.size());
  for (std::size_t i = 0; i < first.size(); ++i) EXPECT_EQ(first[i].data, second[i].data);
  EXPECT_EQ(prefilter_ggx(e, 4).size(), 4u);
  before ? ::setenv("MAQUETTE_CACHE", saved.c_str(), 1) : ::unsetenv("MAQUETTE_CACHE");
  std::filesystem::remove_all(folder);
}

}  // namespace
}  // namespace maquette
