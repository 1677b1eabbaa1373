// Reflection points on patches and triangles: small runs of the campaigns that the benchmark runs in full, and single
// cases.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "render/bezier/reflector_patch.h"
#include "render/triangle/triangle_mirror.h"
#include "tests/support/reflection_campaign.h"
#include "tests/support/triangle_campaign.h"

namespace maquette {
namespace {

/// GCC 12's superword vectorisation turns dvec3(vec3(v)) into v.
TEST(FloatRounding, RoundsEveryComponent) {
  const glm::dvec3 v(0.1, 0.2, 0.3), rounded = glm::dvec3(glm::vec3(v));
  for (int i = 0; i < 3; ++i) {
    EXPECT_NE(rounded[i], v[i]);
    EXPECT_NEAR(rounded[i], v[i], 3e-8);
    EXPECT_EQ(rounded[i], static_cast<double>(static_cast<float>(rounded[i])));
  }
  const glm::vec3 t[3] = {{0.1f, 0.2f, 0.3f}, {0.7f, 0.25f, 0.4f}, {0.15f, 0.9f, 0.35f}};
  const glm::vec3 d[3] = {{0.6f, 0.0f, 0.8f}, {0.59f, 0.05f, 0.81f}, {0.61f, -0.05f, 0.79f}};
  const mirror::TriangleMirror m = make_triangle_mirror(t, d);
  for (int i = 0; i < 3; ++i) EXPECT_NE(m.n0_rest[i], 0.0f) << "the lost digits are lost";
}

TEST(BezierReflection, FindsTheMinimumOfAnExhaustiveSearch) {
  const BezierCampaign r = run_bezier_campaign(6000, 11);
  EXPECT_GT(r.inside, 3000u);
  EXPECT_EQ(r.wrong, 0u) << r.failures;
  EXPECT_EQ(r.law_broken, 0u) << r.failures;
  EXPECT_EQ(r.not_finite, 0u);
  EXPECT_LE(r.steps_quantile(0.99), 5);
}

/// A certified case has one reflection point: the exhaustive search never finds a second.
TEST(BezierReflection, CertificateMeansOneMinimum) {
  const BezierCampaign r = run_bezier_campaign(4000, 12);
  EXPECT_EQ(r.several, 0u) << r.failures;
  EXPECT_GT(r.uncertified, 0u) << "the concave side beyond the caustics was not tried";
}

/// Against central differences of the reflection points that the search finds, in double.
TEST(BezierReflection, DerivativeIsThatOfTheReflectionPoint) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int compared = 0;
  for (int n = 0; n < 400; ++n) {
    std::array<glm::dvec3, 16> points{};
    const double curvature = 0.3 * uniform(random);
    for (std::size_t k = 0; k < 16; ++k) {
      const double x = static_cast<double>(k % 4) / 1.5 - 1.0, y = static_cast<double>(k / 4) / 1.5 - 1.0;
      points[k] = {x, 0.7 * y, curvature * (x * x + 0.5 * y * y) + 0.02 * uniform(random)};
    }
    const ReflectorPatch patch = make_reflector_patch(points);
    const glm::dvec3 eye = glm::dvec3(uniform(random), uniform(random), 2.0) - patch.origin;
    const glm::dvec3 p = glm::dvec3(0.7 * uniform(random), 0.5 * uniform(random), 1.2) - patch.origin;
    const auto find = [&](const glm::dvec3& object, const glm::dvec2& from) {
      return bezier_double::reflect_from(patch.exact, eye, object, from, 1.0, 60);
    };
    const auto r = find(p, {0.0, 0.0});
    if (r.status != bezier_double::kReflectionInside || std::max(std::abs(r.x.x), std::abs(r.x.y)) > 0.95) continue;
    const auto d = reflection_derivative(patch.exact, eye, p, r.x);
    const double steepest = std::max(glm::length(d.x), glm::length(d.y));
    if (steepest > 20.0) continue;  // at a caustic
    constexpr double kStep = 1e-2;  // the search ends at 1e-5 rad
    for (int axis = 0; axis < 3; ++axis) {
      glm::dvec3 step(0.0);
      step[axis] = kStep;
      const glm::dvec2 slope = (find(p + step, r.x).x - find(p - step, r.x).x) / (2.0 * kStep);
      EXPECT_NEAR(slope.x, d.x[axis], 0.01 * (1.0 + steepest * steepest));
      EXPECT_NEAR(slope.y, d.y[axis], 0.01 * (1.0 + steepest * steepest));
    }
    ++compared;
  }
  EXPECT_GT(compared, 100);
}

/// A bowl of radius 1 seen from a distance of 2 focuses at 2 / 3: an object beyond is marked, one before is not.
TEST(BezierReflection, CausticIsDetected) {
  std::array<glm::dvec3, 16> points{};
  for (std::size_t j = 0; j < 4; ++j)
    for (std::size_t i = 0; i < 4; ++i) {
      const double x = 0.3 * (static_cast<double>(i) / 1.5 - 1.0), y = 0.3 * (static_cast<double>(j) / 1.5 - 1.0);
      // Control values of (x^2 + y^2) / 2: the ends of x^2 are 0.09, its middle ones -0.03.
      const double bx = i == 0 || i == 3 ? 0.09 : -0.03, by = j == 0 || j == 3 ? 0.09 : -0.03;
      points[4 * j + i] = {x, y, 0.5 * (bx + by)};
    }
  const ReflectorPatch patch = make_reflector_patch(points);
  const glm::dvec3 eye = glm::dvec3(0.0, 0.0, 2.0) - patch.origin;
  const bezier_double::BezierNode middle = bezier_node(patch.exact, eye, {0.0, 0.0});
  EXPECT_NEAR(1.0 / middle.inverse_focus, 1.0 / (2.0 / 1.0 - 1.0 / 2.0), 1e-9);  // 1 / a + 1 / b = 2 / R
  const auto sides = make_reflector_nodes(patch, eye);
  ASSERT_EQ(sides.size(), 1u);
  const glm::vec3 origin(patch.origin);
  EXPECT_TRUE(best_start(sides[0], glm::vec3(eye), glm::vec3(0.0f, 0.05f, 0.3f) - origin).certified);
  EXPECT_FALSE(best_start(sides[0], glm::vec3(eye), glm::vec3(0.0f, 0.05f, 1.5f) - origin).certified);
}

TEST(BezierReflection, BadPatchesAreReportedAndStayFinite) {
  std::array<glm::dvec3, 16> points{};
  points.fill({1.0, 2.0, 3.0});
  EXPECT_TRUE(make_reflector_patch(points).degenerate);
  for (std::size_t k = 0; k < 16; ++k)
    points[k] = {static_cast<double>(k % 4), static_cast<double>(k / 4), 0.25 * static_cast<double>(k % 4)};
  EXPECT_TRUE(make_reflector_patch(points).flat);
  for (std::size_t k = 0; k < 4; ++k) points[k] = {1.5, -1.0, 0.4};  // a collapsed edge
  const ReflectorPatch patch = make_reflector_patch(points);
  EXPECT_FALSE(patch.degenerate);
  std::mt19937 random(5);
  std::uniform_real_distribution<float> uniform(-3.0f, 3.0f);
  for (int n = 0; n < 2000; ++n) {
    glm::vec3 eye(uniform(random), uniform(random), uniform(random)),
        p(uniform(random), uniform(random), uniform(random));
    if (n % 7 == 0) eye = glm::vec3(bezier_position(patch.exact, {0.1, 0.2}));  // the eye on the surface
    if (n % 11 == 0) p = eye;
    for (const ReflectorNodes& side : make_reflector_nodes(patch, glm::dvec3(eye))) {
      const auto r = reflection_point(patch.single, eye, p, best_start(side, eye, p), true);
      ASSERT_TRUE(std::isfinite(r.x.x + r.x.y + r.length_m + r.position.x + r.position.y + r.position.z));
    }
  }
}

TEST(TriangleReflection, FindsEverySimpleRootOfLongDouble) {
  const TriangleCampaign r = run_triangle_campaign(20000, 21);
  EXPECT_GT(r.simple_roots, 20000u);
  EXPECT_EQ(r.missed, 0u) << r.failures;
  EXPECT_EQ(r.stray, 0u) << r.failures;
  EXPECT_EQ(r.wrong_choice, 0u) << r.failures;
  EXPECT_EQ(r.not_finite, 0u);
}

/// The variant that the source rejects: directions in two planes (scaled to height 1 above the triangle) give a linear
/// equation for k, and a wrong point at grazing angles. The error is that of the reflected direction in the middle of
/// the triangle.
TEST(TriangleReflection, TwoPlaneDirectionsFailAtGrazingAngles) {
  const auto error_rad = [](double elevation, bool two_planes) {
    const glm::dvec3 t[3] = {{-0.05, -0.03, 0.0}, {0.05, -0.03, 0.0}, {0.0, 0.06, 0.0}};
    const glm::dvec3 eye = 1.0 * glm::dvec3(-std::cos(elevation), 0.0, std::sin(elevation));
    glm::dvec3 sum(0.0);
    const auto reflected = [&](const glm::dvec3& at) {
      const glm::dvec3 n = glm::normalize(glm::dvec3(-at.x, -at.y, 2.0)),
                       in = glm::normalize(at - eye);  // radius 2, concave
      return in - 2.0 * glm::dot(in, n) * n;
    };
    for (const glm::dvec3& v : t) {
      glm::dvec3 d = reflected(v);
      if (two_planes) d /= d.z;
      sum += d / 3.0;
    }
    const glm::dvec3 truth = reflected(glm::dvec3(0.0));
    sum = glm::normalize(sum);
    return std::atan2(glm::length(glm::cross(sum, truth)), glm::dot(sum, truth));
  };
  EXPECT_LT(error_rad(1.0, true), 4.0 * error_rad(1.0, false) + 1e-4);
  EXPECT_GT(error_rad(0.06, true), 10.0 * error_rad(0.06, false));
}

}  // namespace
}  // namespace maquette
