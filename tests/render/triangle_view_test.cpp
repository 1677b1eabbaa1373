#include "render/lights/triangle_view.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "tests/support/chi_square.h"

namespace maquette {
namespace {

/// See brdf_chi_square_test.cpp.
constexpr double kLeastP = 1e-7;

LightRecord triangle(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c, bool both_sides) {
  LightRecord light{};
  light.kind = shared::kLightTriangle;
  light.position = glm::vec3(a);
  light.direction = glm::vec3(b - a);
  light.edge2 = glm::vec3(c - a);
  light.range_m = both_sides ? 1.0f : 0.0f;
  light.color = glm::vec3(1.0f);
  return light;
}

/// Source: van Oosterom and Strackee 1983, Eq. 8.
double solid_angle_of(const glm::dvec3& a, const glm::dvec3& b, const glm::dvec3& c) {
  const double la = glm::length(a), lb = glm::length(b), lc = glm::length(c);
  return 2.0 * std::atan2(std::abs(glm::dot(a, glm::cross(b - a, c - a))),
                          la * lb * lc + glm::dot(a, b) * lc + glm::dot(b, c) * la + glm::dot(c, a) * lb);
}

struct TriangleCase {
  const char* name;
  glm::dvec3 a{}, b{}, c{};  ///< m, seen from the origin
};

/// Checks that directions to a triangle have the stated density and hit it at the stated point.
void expect_even_directions(const TriangleCase& seen, std::size_t samples, std::mt19937& random) {
  constexpr int kSide = 8;  // of equal triangles along an edge
  const auto& [name, corner_a, corner_b, corner_c] = seen;
  const LightRecord light = triangle(corner_a, corner_b, corner_c, true);
  const glm::dvec3 a(light.position), along(light.direction), across(light.edge2);
  const auto at = [&](double i, double j) { return a + along * (i / kSide) + across * (j / kSide); };
  std::vector<double> expected(2 * kSide * kSide, 0.0), counted(expected.size(), 0.0);
  const double whole = solid_angle_of(a, a + along, a + across);
  double sum = 0.0;
  for (int i = 0; i < kSide; ++i)
    for (int j = 0; i + j < kSide; ++j) {
      const auto bin = static_cast<std::size_t>(2 * (i * kSide + j));
      expected[bin] = solid_angle_of(at(i, j), at(i + 1, j), at(i, j + 1));
      if (i + j + 1 < kSide) expected[bin + 1] = solid_angle_of(at(i + 1, j + 1), at(i + 1, j), at(i, j + 1));
      sum += expected[bin] + expected[bin + 1];
    }
  EXPECT_NEAR(sum, whole, 1e-9 * whole);
  const TriangleView view(light, glm::vec3(0.0f));
  EXPECT_NEAR(view.solid_angle(), whole, 1e-6 * whole);
  for (double& e : expected) e *= static_cast<double>(samples) / whole;
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  const double size = std::max({glm::length(a), glm::length(along), glm::length(across)});
  double worst = 0.0;
  for (std::size_t s = 0; s < samples; ++s) {
    const float u = unit(random);
    const TriangleView::Sample drawn = view.sample({u, unit(random)});
    const double x = static_cast<double>(drawn.uv.x), y = static_cast<double>(drawn.uv.y);
    ASSERT_TRUE(x >= 0.0 && y >= 0.0 && x + y <= 1.000001);
    // Direction and distance lead to that point of the triangle.
    const glm::dvec3 point = a + along * x + across * y;
    worst = std::max(worst, glm::length(glm::dvec3(drawn.wi) * static_cast<double>(drawn.distance_m) - point) / size);
    const double fi = std::min(x * kSide, kSide - 1e-9), fj = std::min(y * kSide, kSide - 1e-9);
    const int i = static_cast<int>(fi), j = std::min(static_cast<int>(fj), kSide - 1 - i);
    const bool upper = i + j + 1 < kSide && fi - i + fj - j > 1.0;
    counted[static_cast<std::size_t>(2 * (i * kSide + j)) + (upper ? 1 : 0)] += 1.0;
  }
  EXPECT_LT(worst, 5e-7);  // the digits of uv
  const auto result = test::chi_square(expected, counted, 5.0, 1e-6);
  EXPECT_GT(result.p, kLeastP) << name << ": " << result.statistic << " of " << result.freedom;
  EXPECT_EQ(result.outside, 0);
}

class TriangleViews : public testing::TestWithParam<TriangleCase> {};

TEST_P(TriangleViews, AreSampledUniformlyOverTheirSolidAngle) {
  std::mt19937 random(test::test_seed(11));
  expect_even_directions(GetParam(), test::test_samples(100000), random);
}

TEST(TriangleView, RandomTrianglesAreSampledUniformlyOverTheirSolidAngle) {
  std::mt19937 random(test::test_seed(12));
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  const auto size = [&](double least, double most) {
    return std::exp(0.5 * (std::log(most) - std::log(least)) * (unit(random) + 1.0) + std::log(least));
  };
  const auto vector = [&] { return glm::dvec3(unit(random), unit(random), unit(random)); };
  for (int trial = 0; trial < 60; ++trial) {
    const double scale = size(1e-5, 1e5);
    const glm::dvec3 normal = glm::normalize(vector());
    const glm::dvec3 along = glm::normalize(glm::cross(normal, vector())), across = glm::cross(normal, along);
    const auto corner = [&](double height, double x, double y) {
      return scale * (normal * height + along * x + across * y);
    };
    const double height = size(1e-4, 1e2), x = unit(random), y = unit(random);
    const double width = size(0.03, 1.0);
    SCOPED_TRACE("trial " + std::to_string(trial) + ", height " + std::to_string(height) + ", width " +
                 std::to_string(width));
    expect_even_directions({"random", corner(height, x, y), corner(height, x + unit(random), y + width * unit(random)),
                            corner(height, x + unit(random), y + width * unit(random))},
                           test::test_samples(20000), random);
  }
}

INSTANTIATE_TEST_SUITE_P(
    , TriangleViews,
    testing::Values(TriangleCase{"even", {1, 0, 1}, {-1, 1, 1}, {-1, -1, 1}},
                    TriangleCase{"far", {1, 0, 1000}, {-1, 1, 1000}, {-1, -1, 1001}},
                    TriangleCase{"tiny and far", {1e-4, 0, 300}, {0, 1e-4, 300}, {0, -1e-4, 300}},
                    TriangleCase{"near", {1, 0, 1e-3}, {-1, 1, 1e-3}, {-1, -1, 1e-3}},
                    TriangleCase{"touching", {1.1, 0.03, 1e-6}, {-0.9, 1.03, 1e-6}, {-0.9, -0.97, 1e-6}},
                    TriangleCase{"touching, beyond its edge", {1, 1e-4, 1e-4}, {-1, 1e-4, 1e-4}, {0, 1, 1e-4}},
                    TriangleCase{"flat beside its edge", {1, 1e-3, 5e-4}, {-1, 1e-3, 5e-4}, {0, 1, 5e-4}},
                    TriangleCase{"touching, at its edge", {1, 0, 1e-5}, {-1, 0, 1e-5}, {0, 1, 1e-5}},
                    TriangleCase{"beside its edge", {1e-3, 1, 1e-3}, {1e-3, -1, 1e-3}, {2, 0, 1e-3}},
                    TriangleCase{"beside its corner", {1e-3, 0, 1e-3}, {1, 1, 1e-3}, {1, -1, 1e-3}},
                    TriangleCase{"flat", {1, -1, 0.01}, {3, -1, 0.01}, {2, 5, 0.01}},
                    TriangleCase{"needle", {-5, 0, 1}, {5, 0, 1}, {5, 1e-3, 1}},
                    TriangleCase{"short edge first", {5, 0, 1}, {5, 1e-3, 1}, {-5, 0, 1}},
                    TriangleCase{"a micrometre", {1e-6, 0, 1e-6}, {-1e-6, 1e-6, 1e-6}, {-1e-6, -1e-6, 1e-6}},
                    TriangleCase{"a thousand kilometres", {1e6, 0, 1e5}, {-1e6, 1e6, 1e5}, {-1e6, -1e6, 1e5}}),
    [](const auto& value) {
      std::string name = value.param.name;
      std::erase(name, ',');
      std::replace(name.begin(), name.end(), ' ', '_');
      return name;
    });

TEST(TriangleView, EmitsToOneSideUnlessDoubleSided) {
  const glm::dvec3 a(0, 1, 0), b(1, 1, 0), c(0, 1, 1);  // normal -y: down
  EXPECT_GT(TriangleView(triangle(a, b, c, false), {0.2f, 0.0f, 0.2f}).solid_angle(), 0.0);
  EXPECT_EQ(TriangleView(triangle(a, b, c, false), {0.2f, 2.0f, 0.2f}).solid_angle(), 0.0);
  EXPECT_GT(TriangleView(triangle(a, b, c, true), {0.2f, 2.0f, 0.2f}).solid_angle(), 0.0);
  EXPECT_EQ(TriangleView(triangle(a, b, c, true), {5.0f, 1.0f, 0.0f}).solid_angle(), 0.0);  // in its plane
  EXPECT_EQ(TriangleView(triangle(a, b, c, true), {1.0f, 1.0f, 0.0f}).solid_angle(), 0.0);  // at a corner
  EXPECT_EQ(TriangleView(triangle(a, a, a, true), {0.2f, 0.0f, 0.2f}).solid_angle(), 0.0);  // a point
}

/// Rounding puts its points on either side of its plane, where they would see a hemisphere full of its light.
TEST(TriangleView, ItsOwnPointsDoNotSeeIt) {
  std::mt19937 random(test::test_seed(13));
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  const auto vector = [&] { return glm::vec3(unit(random), unit(random), unit(random)) * 2.0f - 1.0f; };
  for (int trial = 0; trial < 2000; ++trial) {
    // Every other triangle around the origin, where coordinates are small but their rounding errors are not.
    const bool around = trial % 2 == 1;
    const glm::vec3 a = 3.0f * vector(), b = a + vector(), c = around ? -(a + b) : a + vector();
    const LightRecord light = triangle(a, b, c, true);
    const float u = around ? 1.0f / 3.0f + 1e-6f * unit(random) : unit(random);
    const float v = around ? 1.0f / 3.0f + 1e-6f * unit(random) : unit(random) * (1.0f - u);
    const glm::vec3 point = a * (1.0f - u - v) + b * u + c * v;
    ASSERT_EQ(TriangleView(light, point).solid_angle(), 0.0) << trial;
    const glm::vec3 normal = glm::normalize(glm::cross(light.direction, light.edge2));
    ASSERT_GT(TriangleView(light, point + 1e-4f * normal).solid_angle(), 0.0) << trial;
  }
}

}  // namespace
}  // namespace maquette
