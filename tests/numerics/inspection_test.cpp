// What the inspection of panes computes without pictures, against closed forms, published values and an independent
// trace in long double.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "render/inspection/eye_points.h"
#include "render/inspection/light_on_pane.h"
#include "render/inspection/pane_optics.h"
#include "render/inspection/statistics.h"
#include "render/math/shared_formulas.h"
#include "scenes/error.h"

namespace maquette {
namespace {

constexpr double kDegree_rad = std::numbers::pi / 180.0, kInfinity = std::numeric_limits<double>::infinity();

/// The published values were rounded twice, to four decimals and then to three: 0.0975 and 0.0925 became 0.098 and
/// 0.093.
TEST(PaneOptics, HaveThePublishedValues) {
  const struct {
    double degrees, surface, pane;
  } published[] = {{45.0, 0.053, 0.098}, {60.0, 0.093, 0.157}, {65.0, 0.124, 0.203}, {70.0, 0.175, 0.275}};
  for (const auto& v : published) {
    const PaneOptics o = pane_optics(v.degrees * kDegree_rad, 1.52, 1.0);
    EXPECT_NEAR(o.surface.mean(), v.surface, 5.5e-4) << v.degrees;
    EXPECT_NEAR(o.reflected.mean(), v.pane, 5.5e-4) << v.degrees;
    EXPECT_NEAR(o.reflected.mean() + o.transmitted.mean(), 1.0, 1e-12);
  }
}

/// Each polarisation against the geometric series written out, in long double, and the renderer's float.
TEST(PaneOptics, EachPolarisationIsTheSumOfItsBounces) {
  std::mt19937 random(36);
  std::uniform_real_distribution<double> angle(0.0, 89.9), index(1.01, 2.4), inner(0.0, 1.0);
  for (int k = 0; k < 500; ++k) {
    const double theta = angle(random) * kDegree_rad, n = index(random), t = k % 7 == 0 ? 1.0 : inner(random);
    const long double c = std::cos(static_cast<long double>(theta)), s = std::sin(static_cast<long double>(theta));
    const long double c2 = std::sqrt(1.0L - s * s / (n * n));
    const long double rs = std::pow((c - n * c2) / (c + n * c2), 2), rp = std::pow((n * c - c2) / (n * c + c2), 2);
    const PaneOptics o = pane_optics(theta, n, t);
    const auto pane = [&](long double r) {  // peers: R1 + (1 - R1)^2 R1 t^2 / (1 - R1^2 t^2)
      return static_cast<double>(r + (1.0L - r) * (1.0L - r) * r * t * t / (1.0L - r * r * t * t));
    };
    EXPECT_NEAR(o.surface.s, static_cast<double>(rs), 1e-12);
    EXPECT_NEAR(o.surface.p, static_cast<double>(rp), 1e-12);
    EXPECT_NEAR(o.reflected.s, pane(rs), 1e-11);
    EXPECT_NEAR(o.reflected.p, pane(rp), 1e-11);
    const glm::vec2 drawn =
        shared::fresnel_pane(static_cast<float>(std::cos(theta)), static_cast<float>(n), static_cast<float>(t));
    EXPECT_NEAR(o.reflected.mean(), static_cast<double>(drawn.x), 2e-6) << "the renderer's own";
    EXPECT_NEAR(o.transmitted.mean(), static_cast<double>(drawn.y), 2e-6);
  }
}

/// The angle between both images by intersecting lines, without the renderer's formulas.
long double traced_ghost_angle(const GhostView& v) {
  const long double s = std::sin(static_cast<long double>(v.incidence_rad)), c = std::sqrt(1.0L - s * s);
  const long double n = v.refractive_index, wedge = v.wedge_rad;
  const auto miss = [&](long double angle) {
    const long double turned = v.incidence_rad + angle, dx = std::sin(turned), dy = -std::cos(turned);
    const long double px = -v.eye_m * s - v.eye_m * c / dy * dx;  // on the front face, y = 0
    const long double ix = dx / n, iy = -std::sqrt(1.0L - ix * ix), slope = std::tan(wedge);
    const long double k = (-v.thickness_m + slope * px) / (iy - slope * ix), bx = px + k * ix, by = k * iy;
    const long double nx = -std::sin(wedge), ny = std::cos(wedge), q = 2.0L * (ix * nx + iy * ny);
    const long double mx = ix - q * nx, my = iy - q * ny, fx = bx - by / my * mx;
    const long double ox = n * mx, oy = std::sqrt(1.0L - ox * ox);
    const bool far = std::isinf(v.object_m);
    const long double wx = far ? s : v.object_m * s - fx, wy = far ? c : v.object_m * c;
    return ox * wy - oy * wx;
  };
  long double low = -0.05L, high = 0.05L;
  for (int i = 0; i < 100; ++i) {
    const long double middle = 0.5L * (low + high);
    (miss(middle) > 0.0L) == (miss(low) > 0.0L) ? low = middle : high = middle;
  }
  return -0.5L * (low + high);
}

TEST(GhostAngle, EqualsAnIndependentTrace) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> angle(5.0, 75.0), distance(0.2, 3.0), wedge(-2e-3, 2e-3), depth(2e-3, 8e-3);
  for (int k = 0; k < 300; ++k) {
    const GhostView v{angle(random) * kDegree_rad,
                      1.52,
                      depth(random),
                      k % 4 == 0 ? 0.0 : wedge(random),
                      k % 5 == 0 ? kInfinity : distance(random),
                      distance(random)};
    const double traced = static_cast<double>(traced_ghost_angle(v));
    // A hundredth, and a hundredth of an arc minute where both images nearly coincide.
    EXPECT_NEAR(ghost_angle_rad(v), traced, 0.01 * std::abs(traced) + 0.01 * kArcMinute_rad)
        << v.incidence_rad / kDegree_rad << " " << v.wedge_rad << " " << v.object_m;
  }
}

TEST(GhostAngle, OfAFlatWedgeAgreesWithItsClosedForm) {
  for (const double degrees : {0.0, 30.0, 45.0, 60.0, 65.0, 70.0}) {
    const double theta = degrees * kDegree_rad, s = std::sin(theta);
    for (const double alpha : {1e-4, 5e-4, -5e-4}) {
      const double closed = 2.0 * alpha * std::sqrt(1.52 * 1.52 - s * s) / std::cos(theta);
      EXPECT_NEAR(secondary_image_angle_rad(theta, 1.52, 0.005, alpha, kInfinity), closed, 1e-12);
      const GhostView far{theta, 1.52, 0.005, alpha, kInfinity, 0.75};
      EXPECT_NEAR(ghost_angle_rad(far), -closed, 0.01 * std::abs(closed)) << degrees << " " << alpha;
    }
    const GhostView flat{theta, 1.52, 0.005, 0.0, 0.5, 0.75};
    EXPECT_NEAR(ghost_angle_rad(flat), ghost_offset_m(theta, 1.52, 0.005) / 1.25,
                0.01 * ghost_offset_m(theta, 1.52, 0.005) / 1.25);
  }
  // Published offsets of 5 mm, in mm.
  EXPECT_NEAR(ghost_offset_m(45.0 * kDegree_rad, 1.52, 0.005), 3.72e-3, 5e-6);
  EXPECT_NEAR(ghost_offset_m(60.0 * kDegree_rad, 1.52, 0.005), 3.47e-3, 5e-6);
  EXPECT_NEAR(ghost_offset_m(70.0 * kDegree_rad, 1.52, 0.005), 2.69e-3, 5e-6);
}

TEST(GhostAngle, VanishesAtTheWedgeThatIsStated) {
  for (const double degrees : {30.0, 50.0, 62.0}) {
    GhostView v{degrees * kDegree_rad, 1.52, 0.005, 0.0, 0.5, 0.75};
    const double before = ghost_angle_rad(v);
    v.wedge_rad = wedge_without_ghost_rad(v);
    EXPECT_LT(std::abs(static_cast<double>(traced_ghost_angle(v))), 0.03 * before) << degrees;
    // A far source seen through a curved pane: d sin theta cos theta / (Rc (n^2 - sin^2 theta)).
    const double s = std::sin(v.incidence_rad), c = std::cos(v.incidence_rad);
    const double removing = 0.005 * s * c / (8.0 * (1.52 * 1.52 - s * s));
    EXPECT_NEAR(secondary_image_angle_rad(v.incidence_rad, 1.52, 0.005, removing, 8.0), 0.0, 1e-12);
  }
}

TEST(FlatVeil, IsThePublishedEstimate) {
  const auto veil = [](double degrees) {
    return flat_veil_cdm2(88900.0, 0.75, 0.13, pane_optics(degrees * kDegree_rad, 1.52, 1.0).reflected.mean());
  };
  EXPECT_NEAR(veil(60.0), 432.0, 1.5);
  EXPECT_NEAR(veil(65.0), 560.0, 1.5);
  EXPECT_EQ(contrast_kept(3000.0, 0.0), 1.0);
  EXPECT_EQ(contrast_kept(300.0, 100.0), 0.75);
  EXPECT_EQ(contrast_kept(0.0, 0.0), 0.0);
}

TEST(EyePoints, FollowTheDirective) {
  const VehicleAxes axes = vehicle_axes("-z,-x,+y");
  EXPECT_EQ(axes.rearward, glm::dvec3(0, 0, -1));
  const glm::dvec3 r(0.37, 0.4, -0.2);
  const glm::dvec3 v1 = eye_from_r_point(r, axes, {"V1", false}), v2 = eye_from_r_point(r, axes, {"V2", true});
  EXPECT_LT(glm::length(v1 - (r + glm::dvec3(0.005, 0.665, -0.068))), 1e-12);
  EXPECT_LT(glm::length(v2 - (r + glm::dvec3(-0.005, 0.589, -0.068))), 1e-12);
  EXPECT_LT(glm::length(eye_from_r_point(r, axes, {"100,20,-30", false}) - (r + glm::dvec3(-0.02, -0.03, -0.1))),
            1e-12);
  EXPECT_THROW(eye_from_r_point(r, axes, {"V3", false}), UsageError);
  for (const char* bad : {"z,x", "-z,-x,-y", "z,z,y", "a,b,c", "-z,-x,+y,", "zz,x,y"})
    EXPECT_THROW(vehicle_axes(bad), UsageError) << bad;
  EXPECT_NEAR(glm::distance(both_eyes(v1, axes)[0], both_eyes(v1, axes)[1]), 0.065, 1e-12);
  EXPECT_GT(both_eyes(v1, axes)[0].x, both_eyes(v1, axes)[1].x) << "left is at +X of a car that drives towards +Z";
  const std::vector<glm::dvec3> grid = eye_grid(v1, axes, 3, 2, 0.1, 0.04);
  ASSERT_EQ(grid.size(), 6u);
  EXPECT_NEAR(grid[0].y - v1.y, 0.02, 1e-12);
  EXPECT_NEAR(grid[0].x - v1.x, 0.05, 1e-12);
  EXPECT_LT(glm::length(0.5 * (grid[0] + grid[5]) - v1), 1e-12);
  EXPECT_LT(glm::length(eye_grid(v1, axes, 1, 1, 0.1, 0.1)[0] - v1), 1e-12);
}

TEST(LightOnPane, UniformSkyAndLoneSun) {
  Environment sky;
  sky.width = 64;
  sky.height = 32;
  sky.rgb.assign(64 * 32, glm::vec3(100.0f));
  for (const glm::dvec3& n : {glm::dvec3(0, 1, 0), glm::normalize(glm::dvec3(1, 2, -0.5))})
    EXPECT_NEAR(illuminance_lx(sky, 0.3, 2.0, n), 200.0 * std::numbers::pi, 2.0);
  EXPECT_NEAR(illuminance_lx(sky, 0.0, 1.0, {0, 1, 0}, [](const glm::dvec3& d) { return d.x > 0.0; }),
              50.0 * std::numbers::pi, 0.5);
  EXPECT_FALSE(find_sun(sky, 0.0).found);
  sky.rgb[10 * 64 + 20] = glm::vec3(1e7f);
  const glm::dvec3 there = direction_from_latlong(20.5, 10.5, 64, 32);
  const SunPlace sun = find_sun(sky, 0.0);
  ASSERT_TRUE(sun.found);
  EXPECT_LT(glm::length(sun.direction - there), 1e-6);
  EXPECT_LT(glm::length(direction_of(sun.elevation_deg, sun.azimuth_deg) - there), 1e-6);
  const SunPlace turned = find_sun(sky, 20.0 * kDegree_rad);
  EXPECT_NEAR(turned.azimuth_deg - sun.azimuth_deg, 20.0, 1e-6) << "positive from +Z towards +X";
  EXPECT_NEAR(turned.elevation_deg, sun.elevation_deg, 1e-6);
}

TEST(LightOnPane, TheBuiltInSunStandsWhereItIsDeclared) {
  const Environment sky = load_environment("builtin:clear-sky");
  const SunPlace sun = find_sun(sky, 0.0);
  ASSERT_TRUE(sun.found);
  EXPECT_NEAR(sun.elevation_deg, 40.0, 0.3);
  EXPECT_NEAR(sun.azimuth_deg, 50.0, 0.3);
  EXPECT_NEAR(illuminance_lx(sky, 0.0, 1.0, sun.direction), 127500.0 * std::exp(-0.21 / std::sin(40.0 * kDegree_rad)),
              0.45 * 92000.0)
      << "the sun's own and the sky about it";
}

TEST(RegionStatistics, AgainstTheDefinitions) {
  const RegionStatistics r = region_statistics({4.0, 1.0, 3.0, 2.0}, 2.0);
  EXPECT_EQ(r.count, 4u);
  EXPECT_EQ(r.min, 1.0);
  EXPECT_EQ(r.max, 4.0);
  EXPECT_EQ(r.mean, 2.5);
  EXPECT_EQ(r.median, 2.5);
  EXPECT_NEAR(r.sigma, std::sqrt(1.25), 1e-15);
  EXPECT_EQ(r.share_over, 0.5);
  EXPECT_EQ(region_statistics({}, 1.0).count, 0u);
}

/// The interval holds the true mean in 95 of 100 cases.
TEST(RegionStatistics, IntervalsHoldTheMeanAsOftenAsTheySay) {
  std::mt19937 random(11);
  std::normal_distribution<double> noise(5.0, 2.0);
  for (const std::size_t count : {2u, 4u, 8u, 20u}) {
    int held = 0;
    constexpr int kTrials = 4000;
    for (int trial = 0; trial < kTrials; ++trial) {
      std::vector<double> estimates(count);
      for (double& e : estimates) e = noise(random);
      const Interval i = confidence_interval(estimates);
      held += std::abs(i.mean - 5.0) <= i.half_width ? 1 : 0;
    }
    EXPECT_NEAR(held / static_cast<double>(kTrials), 0.95, 0.011) << count;
  }
  EXPECT_TRUE(std::isinf(confidence_interval({1.0}).half_width));
}

}  // namespace
}  // namespace maquette
