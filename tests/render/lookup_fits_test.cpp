#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "render/environment/prefilter.h"
#include "render/prefilter/reflectance_tables.h"
#include "render/sg/fit.h"
#include "render/splitsum/fit.h"
#include "tests/support/sheen.h"

namespace {

using namespace maquette;

/// Integral of f(wi, h, wo) cos(theta_i) over the hemisphere, midpoints in double.
double reflected(double nv, const std::function<double(const glm::dvec3&, const glm::dvec3&)>& f) {
  constexpr int kTheta = 800, kPhi = 800;
  const glm::dvec3 wo(std::sqrt(1.0 - nv * nv), 0.0, nv);
  double sum = 0.0;
  for (int i = 0; i < kTheta; ++i) {
    const double theta = std::numbers::pi / 2.0 * (i + 0.5) / kTheta;
    for (int j = 0; j < kPhi; ++j) {
      const double phi = std::numbers::pi * (j + 0.5) / kPhi;  // half of it, by symmetry
      const glm::dvec3 wi(std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta));
      sum += f(wi, glm::normalize(wi + wo)) * wi.z * std::sin(theta);
    }
  }
  return 2.0 * sum * (std::numbers::pi / 2.0 / kTheta) * (std::numbers::pi / kPhi);
}

TEST(SgAlbedo, AgreesWithBruteForce) {
  for (const double sharpness : {0.2, 3.0, 40.0, 900.0})
    for (const double nv : {0.15, 0.5, 0.95}) {
      const double truth =
          reflected(nv, [&](const glm::dvec3&, const glm::dvec3& h) { return std::exp(sharpness * (h.z - 1.0)); });
      EXPECT_NEAR(sg_albedo(sharpness, nv), truth, 0.01 * truth) << sharpness << ' ' << nv;
    }
}

TEST(SgAlbedo, TableMatchesIt) {
  const Image table = sg_albedo_table(32);
  const double sharpness = std::exp2(kSgTableLog2Begin + (kSgTableLog2End - kSgTableLog2Begin) * 10.0 / 31.0);
  const double root = 20.5 / 32.0;
  EXPECT_NEAR(table.at(20, 10), std::log(sg_albedo(sharpness, root * root)), 1e-4);
  for (const float v : table.data) EXPECT_TRUE(std::isfinite(v));
}

TEST(ReflectanceTable, SheenAndSchlickAgreeWithBruteForce) {
  constexpr int kTableSize = 16;
  const Image table = reflectance_table(kTableSize), split = split_sum_table(kTableSize);
  for (const int x : {3, 12}) {
    const double nv = (x + 0.5) / kTableSize;
    const double weight = reflected(nv, [&](const glm::dvec3& wi, const glm::dvec3& h) {
      return std::pow(1.0 - glm::dot(wi, h), 5.0) / std::numbers::pi;
    });
    EXPECT_NEAR(table.at(x, 5, 3), weight, 0.01 * weight + 1e-5);
    for (const int y : {6, 14}) {
      const double roughness = (y + 0.5) / kTableSize;
      const glm::dvec3 wo(std::sqrt(1.0 - nv * nv), 0.0, nv);
      const double sheen = reflected(
          nv, [&](const glm::dvec3& wi, const glm::dvec3&) { return test::sheen_lobe(wi, wo, roughness * roughness); });
      EXPECT_NEAR(table.at(x, y, 2), sheen, 0.02 * sheen + 1e-4) << x << ' ' << y;
      EXPECT_EQ(table.at(x, y, 0), split.at(x, y, 0));
      EXPECT_EQ(table.at(x, y, 1), split.at(x, y, 1));
    }
  }
}

TEST(SplitsumFit, FindsTheReflectancesThatMadeAnAlbedo) {
  const Image table = reflectance_table(64);
  GgxFit shape;
  shape.diffuse = {0.1f, 0.0f, 0.05f};
  shape.alpha = (20.5f / 64.0f) * (20.5f / 64.0f);
  shape.specular = glm::vec3(0.9f);  // instead of the fitted value
  const glm::vec3 f0(0.04f, 0.5f, 0.0f), f90(1.0f, 0.7f, 0.3f);
  std::vector<glm::vec3> albedo;
  for (int i = 0; i < 64; ++i) {
    const double at = std::clamp(std::cos(std::numbers::pi / 2.0 * i / 63.0) * 64.0 - 0.5, 0.0, 63.0);
    const int x = std::min(static_cast<int>(at), 62);
    const auto f = static_cast<float>(at - x);
    const float a = table.at(x, 20, 0) * (1.0f - f) + table.at(x + 1, 20, 0) * f;
    const float b = table.at(x, 20, 1) * (1.0f - f) + table.at(x + 1, 20, 1) * f;
    albedo.push_back(shape.diffuse + f0 * a + f90 * b);
  }
  const SplitsumFit fit = fit_energy(shape, albedo, table);
  for (int c = 0; c < 3; ++c) {
    EXPECT_NEAR(fit.f0[c], f0[c], 0.01f) << c;
    EXPECT_NEAR(fit.f90[c], f90[c], 0.02f) << c;
    EXPECT_NEAR(fit.diffuse[c], shape.diffuse[c], 1e-6f) << c;
  }
}

TEST(SplitsumFit, BlackTableReflectsNothing) {
  const SplitsumFit fit = fit_energy(GgxFit{}, std::vector<glm::vec3>(64, glm::vec3(0.0f)), reflectance_table(16));
  for (const glm::vec3& v : {fit.diffuse, fit.f0, fit.f90})
    for (int c = 0; c < 3; ++c) EXPECT_EQ(v[c], 0.0f);
}

TEST(SgEnergy, GivesEachElevationItsAlbedo) {
  SgFit shape;
  shape.diffuse = glm::vec3(0.3f);
  shape.lobes = {{glm::vec3(2.0f, 3.0f, 0.0f), glm::vec3(200.0f, 30.0f, 1.0f)}};
  std::vector<glm::vec3> albedo;
  for (int i = 0; i < 64; ++i) albedo.emplace_back(0.2f + 0.005f * static_cast<float>(i));
  const SgEnergy energy = fit_energy(shape, albedo);
  ASSERT_EQ(energy.view_factor.size(), 64u);
  EXPECT_NEAR(energy.diffuse.x, 0.2f, 1e-6f);
  for (const std::size_t i : {0u, 30u, 60u}) {
    const double nv = std::cos(std::numbers::pi / 2.0 * static_cast<double>(i) / 63.0);
    for (int c = 0; c < 2; ++c) {
      const double lobes = static_cast<double>(shape.lobes[0].amplitude[c]) *
                           sg_albedo(static_cast<double>(shape.lobes[0].sharpness[c]), nv);
      EXPECT_NEAR(0.2 + static_cast<double>(energy.view_factor[i][c]) * lobes, albedo[i][c], 1e-4);
    }
    EXPECT_EQ(energy.view_factor[i].z, 0.0f);  // no lobe, no factor
  }
}

}  // namespace
