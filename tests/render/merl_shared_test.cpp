#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>
#include <random>

#include "render/math/shared_formulas.h"

namespace {

using maquette::shared::merl_atan;
using maquette::shared::merl_cell;
using maquette::shared::merl_coordinates;

/// The definition by rotations, in double: an implementation independent of the shared code.
glm::dvec3 coordinates_by_rotation(const glm::dvec3& wi, const glm::dvec3& wo) {
  const glm::dvec3 h = glm::normalize(wi + wo);
  const double theta_h = std::atan2(std::hypot(h.x, h.y), h.z);
  const double phi_h = std::atan2(h.y, h.x);
  const glm::dvec3 a(wi.x * std::cos(phi_h) + wi.y * std::sin(phi_h), -wi.x * std::sin(phi_h) + wi.y * std::cos(phi_h),
                     wi.z);
  const glm::dvec3 d(a.x * std::cos(theta_h) - a.z * std::sin(theta_h), a.y,
                     a.x * std::sin(theta_h) + a.z * std::cos(theta_h));
  const double theta_d = std::atan2(std::hypot(d.x, d.y), d.z);
  double phi_d = std::atan2(d.y, d.x);
  if (phi_d < 0.0) phi_d += glm::pi<double>();
  return {90.0 * std::sqrt(theta_h / glm::half_pi<double>()) - 0.5, 90.0 * theta_d / glm::half_pi<double>() - 0.5,
          180.0 * phi_d / glm::pi<double>() - 0.5};
}

glm::dvec3 unit_of(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}

double periodic_difference(double a, double b) {
  const double d = std::fmod(std::abs(a - b), 180.0);
  return std::min(d, 180.0 - d);
}

/// Tolerances in bins. phi_d is undefined where h = n or wi = wo; there the comparison uses the distance by which it
/// moves across h.
void expect_agreement(const glm::vec3& wi, const glm::vec3& wo, double tolerance) {
  const glm::vec3 actual = merl_coordinates(wi, wo);
  const glm::dvec3 expected = coordinates_by_rotation(wi, wo);
  EXPECT_NEAR(actual.x, expected.x, tolerance);
  EXPECT_NEAR(actual.y, expected.y, tolerance);
  const double sin_h = std::sin(std::pow((expected.x + 0.5) / 90.0, 2) * glm::half_pi<double>());
  const double sin_d = std::sin((expected.y + 0.5) / 90.0 * glm::half_pi<double>());
  EXPECT_LT(periodic_difference(actual.z, expected.z) * std::min(1.0, 20.0 * sin_h * sin_d), tolerance)
      << "expected " << expected.z << " actual " << actual.z << " sin_h " << sin_h << " sin_d " << sin_d;
  EXPECT_GE(actual.z, -0.5f);
  EXPECT_LE(actual.z, 179.5001f);
}

TEST(MerlShared, AtanIsAccurate) {
  double worst = 0.0, worst_relative = 0.0;
  for (int i = 0; i <= 20000; ++i) {
    const double angle = glm::half_pi<double>() * i / 20000.0;
    const double actual = merl_atan(static_cast<float>(std::sin(angle)), static_cast<float>(std::cos(angle)));
    worst = std::max(worst, std::abs(actual - angle));
    if (i > 0) worst_relative = std::max(worst_relative, std::abs(actual / angle - 1.0));
  }
  EXPECT_LT(worst, 2.5e-6);
  EXPECT_LT(worst_relative, 3e-5);
  EXPECT_EQ(merl_atan(0.0f, 0.0f), 0.0f);
  EXPECT_NEAR(merl_atan(1e-6f, 1.0f), 1e-6, 1e-10);
}

TEST(MerlShared, RandomPairsAgreeWithRotations) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int i = 0; i < 20000; ++i) {
    const glm::vec3 wi(unit_of(std::acos(unit(random)), 6.2831853 * unit(random)));
    const glm::vec3 wo(unit_of(std::acos(unit(random)), 6.2831853 * unit(random)));
    expect_agreement(wi, wo, 2e-3);
  }
}

TEST(MerlShared, GrazingPairsAgreeWithRotations) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int i = 0; i < 5000; ++i) {
    const double elevation = 1e-4 + 0.02 * unit(random);
    const glm::vec3 wi(unit_of(glm::half_pi<double>() - elevation, 6.2831853 * unit(random)));
    const glm::vec3 wo(unit_of(std::acos(unit(random)), 6.2831853 * unit(random)));
    expect_agreement(wi, wo, 2e-3);
  }
}

TEST(MerlShared, NearMirrorPairsKeepSmallThetaH) {
  std::mt19937 random(3);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int i = 0; i < 5000; ++i) {
    const double theta = 1.5 * unit(random), phi = 6.2831853 * unit(random);
    const double offset = std::pow(10.0, -5.0 + 4.0 * unit(random));
    const glm::vec3 wo(unit_of(theta, phi));
    const glm::vec3 wi(unit_of(theta + offset, phi + glm::pi<double>() + offset * (unit(random) - 0.5)));
    const glm::vec3 actual = merl_coordinates(wi, wo);
    const glm::dvec3 expected = coordinates_by_rotation(wi, wo);
    // Rounding of the float directions themselves is about 1e-7 rad, 0.02 bins at theta_h = 0 and falling as 1 / sqrt.
    EXPECT_NEAR(actual.x, expected.x, offset > 1e-4 ? 2e-3 : 3e-2) << offset;
    EXPECT_NEAR(actual.y, expected.y, 2e-3);
  }
}

TEST(MerlShared, ExactMirrorIsAtTheLobeCentre) {
  for (double theta : {0.0, 0.1, 0.7, 1.2, 1.57}) {
    const glm::vec3 wo(unit_of(theta, 0.3));
    const glm::vec3 wi(-wo.x, -wo.y, wo.z);
    const glm::vec3 c = merl_coordinates(wi, wo);
    EXPECT_EQ(c.x, -0.5f);
    EXPECT_NEAR(c.y, theta / glm::half_pi<double>() * 90.0 - 0.5, 1e-3);
    EXPECT_TRUE(std::isfinite(c.z));
  }
}

TEST(MerlShared, IdenticalAndNearlyIdenticalDirectionsHaveSmallThetaD) {
  for (double theta : {0.0, 1e-4, 0.5, 1.2, 1.5}) {
    const glm::vec3 wo(unit_of(theta, 1.0));
    const glm::vec3 same = merl_coordinates(wo, wo);
    EXPECT_EQ(same.y, -0.5f);
    EXPECT_NEAR(same.x, 90.0 * std::sqrt(theta / glm::half_pi<double>()) - 0.5, 2e-2 / (1.0 + 1e4 * theta) + 2e-3);
    EXPECT_TRUE(std::isfinite(same.z));
    const glm::vec3 close = merl_coordinates(glm::vec3(unit_of(theta + 1e-5, 1.0)), wo);
    EXPECT_NEAR(close.y, -0.5, 1e-3);
  }
}

TEST(MerlShared, ReciprocalPairsGiveTheSameEntry) {
  std::mt19937 random(4);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  for (int i = 0; i < 5000; ++i) {
    const glm::vec3 wi(unit_of(std::acos(unit(random)), 6.2831853 * unit(random)));
    const glm::vec3 wo(unit_of(std::acos(unit(random)), 6.2831853 * unit(random)));
    const glm::vec3 a = merl_coordinates(wi, wo), b = merl_coordinates(wo, wi);
    EXPECT_EQ(a.x, b.x);
    EXPECT_EQ(a.y, b.y);
    EXPECT_LT(periodic_difference(a.z, b.z), 1e-4);
  }
}

TEST(MerlShared, CellsClampAndWrap) {
  const auto low = merl_cell(glm::vec3(-0.5f, -0.5f, -0.5f));
  EXPECT_EQ(low.lower, glm::ivec3(0, 0, 179));
  EXPECT_EQ(low.upper, glm::ivec3(1, 1, 0));
  EXPECT_EQ(low.fraction, glm::vec3(0.0f, 0.0f, 0.5f));
  const auto high = merl_cell(glm::vec3(89.5f, 89.5f, 179.5f));
  EXPECT_EQ(high.lower, glm::ivec3(88, 88, 179));
  EXPECT_EQ(high.upper, glm::ivec3(89, 89, 0));
  EXPECT_EQ(high.fraction, glm::vec3(1.0f, 1.0f, 0.5f));
  const auto middle = merl_cell(glm::vec3(10.25f, 20.75f, 30.5f));
  EXPECT_EQ(middle.lower, glm::ivec3(10, 20, 30));
  EXPECT_EQ(middle.fraction, glm::vec3(0.25f, 0.75f, 0.5f));
  // Just below zero after rounding: -1e-9 + 180 is 180 in float and must not index past the end.
  EXPECT_EQ(merl_cell(glm::vec3(0.0f, 0.0f, -1e-9f)).lower.z, 179);
}

}  // namespace
