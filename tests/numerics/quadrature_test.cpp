#include "tests/support/quadrature.h"

#include <gtest/gtest.h>

#include <cmath>
#include <iostream>
#include <numbers>
#include <random>

#include "scenes/parallel.h"

namespace maquette::test {
namespace {

Environment make_environment(int width, int height, const std::function<glm::dvec3(const glm::dvec3&)>& radiance) {
  Environment e;
  e.width = width;
  e.height = height;
  for (int y = 0; y < height; ++y) {
    for (int x = 0; x < width; ++x)
      e.rgb.emplace_back(radiance(direction_from_latlong(x + 0.5, y + 0.5, width, height)));
  }
  return e;
}

/// Uneven sky with a sun of a few texels, its peak more than 1e4 times the mean.
Environment make_sunny(int width, int height) {
  Environment e = make_environment(width, height, [](const glm::dvec3& d) {
    return glm::dvec3(0.6, 0.8, 1.0) * (1.0 + 0.5 * d.y + 0.2 * std::sin(7.0 * d.x) * std::cos(5.0 * d.z));
  });
  const auto at = [&](int x, int y) -> glm::vec3& { return e.rgb[static_cast<std::size_t>(y * width + x)]; };
  at(width / 3, height / 4) = glm::vec3(6e4f, 5e4f, 4e4f);
  at(width / 3 + 1, height / 4) = glm::vec3(3e4f, 2.5e4f, 2e4f);
  return e;
}

BrdfTable make_table(const std::function<glm::dvec3(double theta_h, double theta_d, double phi_d)>& value) {
  BrdfTable table;
  for (int h = 0; h < kThetaHCount; ++h) {
    const double root = (h + 0.5) / kThetaHCount;
    for (int d = 0; d < kThetaDCount; ++d) {
      for (int p = 0; p < kPhiDCount; ++p) {
        table.rgb.emplace_back(value(root * root * std::numbers::pi / 2.0,
                                     (d + 0.5) / kThetaDCount * std::numbers::pi / 2.0,
                                     (p + 0.5) / kPhiDCount * std::numbers::pi));
      }
    }
  }
  return table;
}

const BrdfTable& lambert() {
  static const BrdfTable kTable =
      make_table([](double, double, double) { return glm::dvec3(0.5, 0.25, 0.75) / std::numbers::pi; });
  return kTable;
}

/// A lobe like that of chrome: exp(-(tan / width)^2) / (pi width^2 cos^4), nearly normalised.
const BrdfTable& chrome() {
  static const BrdfTable kTable = make_table([](double theta_h, double theta_d, double) {
    const double width = 0.004;
    const double t = std::tan(theta_h) / width;
    const double d = std::exp(-t * t) / (std::numbers::pi * width * width * std::pow(std::cos(theta_h), 4.0));
    return glm::dvec3(0.9, 0.85, 0.8) * d / (4.0 * std::pow(std::max(std::cos(theta_d), 0.05), 2.0)) + 1e-4;
  });
  return kTable;
}

/// Like metallic paint: two lobes of different width over a coloured base.
const BrdfTable& two_lobes() {
  static const BrdfTable kTable = make_table([](double theta_h, double theta_d, double phi_d) {
    const auto lobe = [&](double width) {
      return std::exp(-std::pow(std::tan(theta_h) / width, 2.0)) / (width * width);
    };
    const double fresnel = 0.05 + 0.95 * std::pow(1.0 - std::cos(theta_d), 5.0);
    return glm::dvec3(0.4, 0.05, 0.05) / std::numbers::pi + fresnel * lobe(0.02) / (4.0 * std::numbers::pi) +
           glm::dvec3(0.3, 0.1, 0.1) * lobe(0.25) / (4.0 * std::numbers::pi) * (1.0 + 0.1 * std::cos(2.0 * phi_d));
  });
  return kTable;
}

LitPoint make_point(double elevation_rad, double azimuth_rad, const glm::dvec3& normal) {
  LitPoint point;
  point.normal = glm::normalize(normal);
  const glm::dvec3 t = glm::normalize(glm::cross(glm::dvec3(0.3, 0.2, 0.9), point.normal));
  const glm::dvec3 b = glm::cross(point.normal, t);
  point.wo = std::sin(elevation_rad) * point.normal +
             std::cos(elevation_rad) * (std::cos(azimuth_rad) * t + std::sin(azimuth_rad) * b);
  return point;
}

double relative_difference(const glm::dvec3& a, const glm::dvec3& b) {
  const glm::dvec3 d = glm::abs(a - b) / b;
  return std::max({d.x, d.y, d.z});
}

/// Independent of the map's tree: midpoint rule over the half vector, with theta_h on the table's own square-root
/// scale.
glm::dvec3 integrate_over_half_vectors(const Environment& environment, const BrdfTable& table, const LitPoint& point,
                                       int theta_count, int phi_count) {
  const glm::dvec3 t = glm::normalize(glm::cross(glm::dvec3(0.1, 0.9, 0.4), point.normal));
  const glm::dvec3 b = glm::cross(point.normal, t);
  const auto local = [&](const glm::dvec3& d) {
    return glm::dvec3(glm::dot(d, t), glm::dot(d, b), glm::dot(d, point.normal));
  };
  const glm::dvec3 wo = local(point.wo);
  std::vector<glm::dvec3> rows(static_cast<std::size_t>(theta_count), glm::dvec3(0.0));
  parallel_for(0, theta_count, [&](int i) {
    const double r = (i + 0.5) / theta_count;
    const double theta = r * r * std::numbers::pi / 2.0;
    const double step = 2.0 * r * std::numbers::pi / 2.0 / theta_count * 2.0 * std::numbers::pi / phi_count;
    glm::dvec3 sum(0.0);
    for (int j = 0; j < phi_count; ++j) {
      const double phi = (j + 0.5) / phi_count * 2.0 * std::numbers::pi;
      const glm::dvec3 h(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
      const double cosine = glm::dot(h, wo);
      const glm::dvec3 wi = 2.0 * cosine * h - wo;
      if (cosine <= 0.0 || wi.z <= 0.0) continue;
      const glm::dvec3 world = wi.x * t + wi.y * b + wi.z * point.normal;
      sum += evaluate_environment(environment, world) * evaluate_brdf(table, wi, wo) *
             (wi.z * 4.0 * cosine * std::sin(theta) * step);
    }
    rows[static_cast<std::size_t>(i)] = sum;
  });
  glm::dvec3 sum(0.0);
  for (const glm::dvec3& row : rows) sum += row;
  return sum;
}

TEST(Quadrature, LambertUnderAConstantSkyIsTheAlbedo) {
  for (const auto& [width, height] : {std::pair{64, 32}, {1, 1}, {37, 23}, {300, 150}}) {
    const EnvironmentMoments sky(
        make_environment(width, height, [](const glm::dvec3&) { return glm::dvec3(2.0, 3.0, 4.0); }));
    for (const LitPoint& point : {make_point(1.2, 0.0, {0.2, 1.0, 0.1}), make_point(0.1, 2.0, {-1.0, -0.3, 0.4})}) {
      const DirectQuadrature got = evaluate_direct(sky, lambert(), point);
      EXPECT_LT(relative_difference(got.radiance, {1.0, 0.75, 3.0}), 5e-4) << width << " x " << height;
    }
  }
}

/// Every texel has its own random radiance, some a thousand times the others: Lambert is a sum over texels.
TEST(Quadrature, LambertUnderRoughRadiance) {
  std::mt19937 random(8);
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  const Environment rough = make_environment(
      90, 45, [&](const glm::dvec3&) { return glm::dvec3(std::pow(uniform(random), 30.0) * 1e3 + uniform(random)); });
  const EnvironmentMoments sky(rough);
  const glm::dvec3 normal = glm::normalize(glm::dvec3(0.3, 0.5, -0.7));
  glm::dvec3 exact(0.0);
  const int fine = 24;  // midpoints a texel
  for (int y = 0; y < 45 * fine; ++y) {
    for (int x = 0; x < 90 * fine; ++x) {
      const double px = (x + 0.5) / fine;
      const double py = (y + 0.5) / fine;
      const glm::dvec3 d = direction_from_latlong(px, py, 90, 45);
      const double cosine = std::max(glm::dot(d, normal), 0.0);
      if (cosine > 0.0) exact += evaluate_environment(rough, d) * cosine * std::sin(std::numbers::pi * py / 45.0);
    }
  }
  exact *= 2.0 * std::numbers::pi * std::numbers::pi / (90.0 * 45.0 * fine * fine) / std::numbers::pi;
  LitPoint point = make_point(0.8, 0.4, normal);
  const DirectQuadrature got = evaluate_direct(sky, lambert(), point);
  EXPECT_LT(relative_difference(got.radiance, exact * glm::dvec3(0.5, 0.25, 0.75)), 5e-4);
  EXPECT_LE(got.relative_error, 1e-4);
}

TEST(Quadrature, MirrorLikeLobeShowsTheSkyBehindIt) {
  const Environment smooth = make_environment(
      512, 256, [](const glm::dvec3& d) { return glm::dvec3(1.0 + 0.5 * d.x, 1.0 + 0.5 * d.y, 1.0 + 0.5 * d.z); });
  const EnvironmentMoments sky(smooth);
  for (double elevation : {1.4, 0.9, 0.4}) {
    const LitPoint point = make_point(elevation, 1.0, {0.2, 0.4, 0.9});
    const DirectQuadrature got = evaluate_direct(sky, chrome(), point);
    const glm::dvec3 exact = integrate_over_half_vectors(smooth, chrome(), point, 2700, 360);
    EXPECT_LT(relative_difference(got.radiance, exact), 5e-4) << elevation;
    const glm::dvec3 mirror = 2.0 * glm::dot(point.normal, point.wo) * point.normal - point.wo;
    const glm::dvec3 seen = evaluate_environment(smooth, mirror) * glm::dvec3(0.9, 0.85, 0.8);
    EXPECT_LT(relative_difference(got.radiance, seen), 0.1) << elevation;  // the lobe is not quite normalised
  }
}

TEST(Quadrature, AgreesWithHalfVectorIntegrationUnderASun) {
  const Environment sunny = make_sunny(256, 128);
  const EnvironmentMoments sky(sunny);
  const glm::dvec3 to_sun = direction_from_latlong(256 / 3 + 0.7, 128 / 4 + 0.5, 256, 128);
  for (const BrdfTable* table : {&two_lobes(), &chrome()}) {
    for (double offset : {0.0, 0.02, 0.3}) {  // the mirror direction from the sun
      LitPoint point = make_point(0.8, 2.0, {0.1, 0.9, 0.3});
      point.wo = glm::normalize(glm::dvec3(0.3, 0.8, -0.2));
      const glm::dvec3 aside = glm::normalize(glm::cross(to_sun, point.wo));
      point.normal = glm::normalize(glm::normalize(to_sun + point.wo) + 0.5 * offset * aside);
      const DirectQuadrature got = evaluate_direct(sky, *table, point);
      const glm::dvec3 exact = integrate_over_half_vectors(sunny, *table, point, 2200, 1000);
      EXPECT_LT(relative_difference(got.radiance, exact), 1e-3)
          << (table == &two_lobes() ? "two lobes " : "chrome ") << offset;
    }
  }
}

/// The quadrature is converged: ten times the effort does not change it, for three tables under the sun.
TEST(Quadrature, ConvergedAtItsDefaultTolerance) {
  const Environment sunny = make_sunny(1024, 512);
  const EnvironmentMoments sky(sunny);
  std::vector<LitPoint> points;
  std::mt19937 random(21);
  std::normal_distribution<double> normal;
  while (points.size() < 10) {
    const glm::dvec3 n = glm::normalize(glm::dvec3(normal(random), normal(random), normal(random)));
    if (n.z > 0.05) {
      LitPoint point;
      point.normal = n;
      point.wo = glm::dvec3(0.0, 0.0, 1.0);
      points.push_back(point);
    }
  }
  for (const BrdfTable* table : {&lambert(), &two_lobes(), &chrome()}) {
    const char* name = table == &lambert() ? "lambert" : table == &two_lobes() ? "two lobes" : "chrome";
    std::vector<double> worst(points.size());
    std::vector<std::size_t> evaluations(points.size());
    parallel_for(std::size_t{0}, points.size(), [&](std::size_t i) {
      DirectQuadratureOptions fine;
      fine.relative_tolerance = 1e-5;
      fine.max_cells = 400000;
      const DirectQuadrature a = evaluate_direct(sky, *table, points[i]);
      const DirectQuadrature b = evaluate_direct(sky, *table, points[i], fine);
      worst[i] = relative_difference(a.radiance, b.radiance);
      evaluations[i] = a.evaluations;
    });
    EXPECT_LT(*std::max_element(worst.begin(), worst.end()), 5e-4) << name;
    std::size_t sum = 0;
    for (std::size_t e : evaluations) sum += e;
    std::cout << name << ": largest change " << *std::max_element(worst.begin(), worst.end()) << ", "
              << sum / points.size() << " evaluations a point" << std::endl;
  }
}

TEST(Quadrature, RotatesTheSky) {
  const Environment sunny = make_sunny(128, 64);
  const EnvironmentMoments sky(sunny);
  LitPoint point = make_point(0.9, 0.3, {0.2, 0.9, 0.4});
  const DirectQuadrature still = evaluate_direct(sky, two_lobes(), point);
  const double angle = 1.1;
  const auto rotate = [&](const glm::dvec3& d) {
    return glm::dvec3(std::cos(angle) * d.x + std::sin(angle) * d.z, d.y,
                      std::cos(angle) * d.z - std::sin(angle) * d.x);
  };
  LitPoint rotated = point;
  rotated.normal = rotate(point.normal);
  rotated.wo = rotate(point.wo);
  rotated.env_rotation_rad = angle;
  EXPECT_LT(relative_difference(evaluate_direct(sky, two_lobes(), rotated).radiance, still.radiance), 1e-9);
}

TEST(Quadrature, VisibilityHidesItsPart) {
  const EnvironmentMoments sky(make_environment(64, 32, [](const glm::dvec3&) { return glm::dvec3(1.0); }));
  LitPoint point = make_point(0.9, 0.3, {0.0, 1.0, 0.0});
  point.visibility = [](const glm::dvec3& w) { return w.x > 0.0 ? 1.0 : 0.0; };
  const DirectQuadrature got = evaluate_direct(sky, lambert(), point);
  EXPECT_LT(relative_difference(got.radiance, glm::dvec3(0.25, 0.125, 0.375)), 1e-3);
}

TEST(Quadrature, BlackSkyAndPointsSeenFromBehindAreDark) {
  const EnvironmentMoments black(make_environment(16, 8, [](const glm::dvec3&) { return glm::dvec3(0.0); }));
  EXPECT_EQ(evaluate_direct(black, lambert(), make_point(0.9, 0.3, {0.0, 1.0, 0.0})).radiance, glm::dvec3(0.0));
  const EnvironmentMoments sky(make_environment(16, 8, [](const glm::dvec3&) { return glm::dvec3(1.0); }));
  EXPECT_EQ(evaluate_direct(sky, lambert(), make_point(-0.5, 0.3, {0.0, 1.0, 0.0})).radiance, glm::dvec3(0.0));
}

}  // namespace
}  // namespace maquette::test
