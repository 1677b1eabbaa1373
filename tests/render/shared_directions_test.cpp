#include <gtest/gtest.h>

#include <glm/glm.hpp>
#include <numbers>
#include <random>
#include <vector>

#include "render/math/shared_formulas.h"

namespace maquette {
namespace {

/// Unit directions: random ones, the axes, near-pole and near-seam ones.
std::vector<glm::vec3> directions() {
  std::vector<glm::vec3> result = {{1, 0, 0}, {-1, 0, 0}, {0, 1, 0}, {0, -1, 0}, {0, 0, 1}, {0, 0, -1}};
  std::mt19937 random(7);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 200000; ++i) {
    glm::dvec3 d(normal(random), normal(random), normal(random));
    if (i % 4 == 1) d.y *= 1e4;             // poles
    if (i % 4 == 2) d.x *= 1e-5, d.z = -1;  // seam
    if (i % 4 == 3) d.y *= 1e-5;            // equator
    result.emplace_back(glm::normalize(d));
  }
  return result;
}

double angle_between(const glm::dvec3& a, const glm::dvec3& b) {
  return std::atan2(glm::length(glm::cross(a, b)), glm::dot(a, b));
}

glm::dvec3 exact_direction(double u, double v) {
  const double lon = std::numbers::pi - 2 * std::numbers::pi * u;
  const double lat = std::numbers::pi / 2 - std::numbers::pi * v;
  return {std::sin(lon) * std::cos(lat), std::sin(lat), std::cos(lon) * std::cos(lat)};
}

TEST(Latlong, PolynomialUvIsWithinTenMicroradians) {
  double worst = 0.0;
  for (const glm::vec3& d : directions()) {
    const glm::vec2 uv = shared::latlong_uv_from_direction(d);
    ASSERT_GE(uv.x, -1e-6f);
    ASSERT_LE(uv.x, 1.0f + 1e-6f);
    worst = std::max(worst, angle_between(exact_direction(uv.x, uv.y), glm::dvec3(d)));
  }
  EXPECT_LT(worst, 1e-5);
}

TEST(Latlong, FollowsTheOpenExrConvention) {
  const auto near = [](glm::vec2 a, glm::vec2 b) { return glm::distance(a, b) < 1e-5f; };
  EXPECT_TRUE(near(shared::latlong_uv_from_direction({0, 0, 1}), {0.5f, 0.5f}));
  EXPECT_TRUE(near(shared::latlong_uv_from_direction({1, 0, 0}), {0.25f, 0.5f}));
  EXPECT_TRUE(near(shared::latlong_uv_from_direction({-1, 0, 0}), {0.75f, 0.5f}));
  EXPECT_NEAR(shared::latlong_uv_from_direction({0, 1, 0}).y, 0.0f, 1e-5f);
  EXPECT_NEAR(shared::latlong_uv_from_direction({0, -1, 0}).y, 1.0f, 1e-5f);
  EXPECT_LT(angle_between(shared::direction_from_latlong_uv({0.25f, 0.5f}), {1, 0, 0}), 1e-6);
}

TEST(Latlong, RoundTrips) {
  for (const glm::vec3& d : directions()) {
    const glm::vec3 back = shared::direction_from_latlong_uv(shared::latlong_uv_from_direction(d));
    ASSERT_LT(angle_between(back, d), 1e-5);
  }
}

TEST(Latlong, RotationIsPositiveFromZTowardsX) {
  EXPECT_LT(angle_between(shared::latlong_rotate({0, 0, 1}, 0.0f, 1.0f), {1, 0, 0}), 1e-6);
  const glm::vec3 d(0.36f, 0.48f, 0.8f);
  const glm::vec3 there = shared::latlong_rotate(d, std::cos(0.7f), std::sin(0.7f));
  EXPECT_LT(angle_between(shared::latlong_rotate(there, std::cos(0.7f), -std::sin(0.7f)), d), 1e-6);
}

TEST(Octahedral, RoundTripsOverTheWholeSphere) {
  for (const glm::vec3& d : directions()) {
    const glm::vec2 uv = shared::octahedral_from_direction(d);
    ASSERT_GE(std::min(uv.x, uv.y), 0.0f);
    ASSERT_LE(std::max(uv.x, uv.y), 1.0f);
    ASSERT_LT(angle_between(shared::direction_from_octahedral(uv), d), 1e-6) << d.x << ' ' << d.y << ' ' << d.z;
  }
}

TEST(Octahedral, PoleIsTheCentreAndAxesFollow) {
  EXPECT_LT(glm::distance(shared::octahedral_from_direction({0, 1, 0}), glm::vec2(0.5f, 0.5f)), 1e-6f);
  EXPECT_LT(glm::distance(shared::octahedral_from_direction({1, 0, 0}), glm::vec2(1.0f, 0.5f)), 1e-6f);
  EXPECT_LT(glm::distance(shared::octahedral_from_direction({0, 0, 1}), glm::vec2(0.5f, 1.0f)), 1e-6f);
  for (const glm::vec2& corner : {glm::vec2(0, 0), glm::vec2(0, 1), glm::vec2(1, 0), glm::vec2(1, 1)})
    EXPECT_LT(angle_between(shared::direction_from_octahedral(corner), {0, -1, 0}), 1e-6);
}

}  // namespace
}  // namespace maquette
