// The radiosity solver that checks the path tracer, checked itself: against closed forms, and against a finer solution.
#include "tests/support/radiosity.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>

#include "scenes/luminance.h"
#include "tests/support/cornell.h"

namespace {

using namespace maquette;
using namespace maquette::test;

void add_quad(const glm::dvec3& origin, const glm::dvec3& a, const glm::dvec3& b, double albedo, double emission,
              std::vector<DiffuseTriangle>* triangles) {
  triangles->push_back({{origin, origin + a, origin + a + b}, glm::dvec3(albedo), glm::dvec3(emission)});
  triangles->push_back({{origin, origin + a + b, origin + b}, glm::dvec3(albedo), glm::dvec3(emission)});
}

/// Two parallel unit squares at unit distance: F = 0.1998 (Howell 2010, catalogue C-11).
TEST(Radiosity, ParallelSquaresExchangeTheirFormFactor) {
  std::vector<DiffuseTriangle> triangles;
  add_quad({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 0.0, 0.0, &triangles);
  add_quad({0, 0, 1}, {0, 1, 0}, {1, 0, 0}, 0.0, std::numbers::pi, &triangles);
  const Radiosity radiosity(triangles, {.largest_edge = 1.5, .rays = 256});
  double mean = 0.0;
  constexpr int kSide = 24;
  for (int i = 0; i < kSide * kSide; ++i)
    mean += radiosity.irradiance({(i % kSide + 0.5) / kSide, (i / kSide + 0.5) / kSide, 0.0}, {0, 0, 1}, 16).x /
            (kSide * kSide);
  EXPECT_NEAR(mean / (std::numbers::pi * std::numbers::pi), 0.199825, 2e-4);
}

/// In a closed box with equal emission and albedo of all walls, exitance is E / (1 - rho) everywhere.
TEST(Radiosity, ClosedFurnaceIsTheGeometricSeries) {
  std::vector<DiffuseTriangle> triangles;
  const double rho = 0.7, emission = 2.0;
  const glm::dvec3 x(1, 0, 0), y(0, 2, 0), z(0, 0, 3);
  add_quad({0, 0, 0}, z, x, rho, emission, &triangles);
  add_quad(y, x, z, rho, emission, &triangles);
  add_quad({0, 0, 0}, x, y, rho, emission, &triangles);
  add_quad(z, y, x, rho, emission, &triangles);
  add_quad({0, 0, 0}, y, z, rho, emission, &triangles);
  add_quad(x, z, y, rho, emission, &triangles);
  const Radiosity radiosity(triangles, {.largest_edge = 1.0, .rays = 512, .light_cells = 4, .far_lights = false});
  EXPECT_LT(radiosity.residual(), 1e-6);
  const glm::dvec3 e = radiosity.irradiance({0.4, 0.0, 1.3}, {0, 1, 0}, 512);
  EXPECT_NEAR(e.x / (std::numbers::pi * emission / (1.0 - rho)), 1.0, 2e-3);
}

/// The solver's own error on the Cornell box, as docs/numerics/path-tracer.md states it.
TEST(Radiosity, CornellBoxIsConverged) {
  const auto triangles = cornell_triangles();
  const double coarse_edge = std::getenv("MAQUETTE_TEST_EFFORT") ? 0.7 : 1.0;  // m
  const Radiosity coarse(triangles, {.largest_edge = coarse_edge, .rays = 1024, .light_cells = 16, .seed = 1});
  const Radiosity fine(triangles, {.largest_edge = 0.7 * coarse_edge, .rays = 1024, .light_cells = 16, .seed = 2});
  const CornellView view(16);
  double difference = 0.0, mean = 0.0;
  int count = 0;
  for (const CornellPixel& pixel : view.pixels(fine)) {
    const auto at = [&](const Radiosity& r) {
      return pixel.hit.albedo / std::numbers::pi * r.irradiance(pixel.hit.position, pixel.hit.normal, 8192);
    };
    const glm::dvec3 a = at(coarse), b = at(fine);
    difference += glm::dot(a - b, a - b) / 3.0;
    mean += luminance(b);
    ++count;
  }
  ASSERT_GT(count, 140);
  const double relative = std::sqrt(difference / count) / (mean / count);
  std::printf("Cornell box: %zu against %zu elements, relative RMSE %.5f\n", coarse.element_count(),
              fine.element_count(), relative);
  EXPECT_LT(relative, 4e-3);
}

}  // namespace
