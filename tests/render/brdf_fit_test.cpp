#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "render/materials/brdf_tables.h"
#include "render/materials/lobes.h"
#include "render/materials/symmetric_brdf.h"

namespace {

using namespace maquette;

/// f(theta_h, theta_d, phi_d) at bin centres; hash 0, so that no fit is read from the cache.
BrdfTable color_table(const std::function<glm::dvec3(double, double, double)>& f) {
  BrdfTable table;
  table.rgb.reserve(kBrdfEntryCount);
  for (int h = 0; h < kThetaHCount; ++h) {
    for (int d = 0; d < kThetaDCount; ++d) {
      for (int p = 0; p < kPhiDCount; ++p) {
        table.rgb.push_back(glm::vec3(
            f(theta_h_of_bin_edge(h + 0.5), (d + 0.5) / 90.0 * kHalfPi, (p + 0.5) / 180.0 * std::numbers::pi)));
      }
    }
  }
  return table;
}

BrdfTable ggx_table(const glm::dvec3& diffuse, const glm::dvec3& f0, double alpha) {
  return color_table([=](double h, double d, double p) {
    const double across = std::sin(h) * std::sin(d) * std::cos(p);
    const double cos_i = std::max(std::cos(h) * std::cos(d) - across, 1e-3),
                 cos_o = std::max(std::cos(h) * std::cos(d) + across, 1e-3);
    const double a2 = alpha * alpha, c2 = std::cos(h) * std::cos(h), t = c2 * (a2 - 1.0) + 1.0;
    const auto smith = [&](double c) { return 2.0 * c / (c + std::sqrt(a2 + (1.0 - a2) * c * c)); };
    const double shape = a2 / (std::numbers::pi * t * t) * smith(cos_i) * smith(cos_o) / (4.0 * cos_i * cos_o);
    const glm::dvec3 fresnel = f0 + (glm::dvec3(1.0) - f0) * std::pow(1.0 - std::cos(d), 5.0);
    return diffuse / std::numbers::pi + fresnel * shape;
  });
}

/// Without a hash nothing is read from or written to the cache.
BrdfTable builtin_uncached(const std::string& name) {
  BrdfTable table = make_builtin_brdf(name);
  table.hash = 0;
  return table;
}

/// Separates the mirroring part from the diffuse part: its albedo, direction and width.
TEST(Lobes, SeparateTheMirroringPart) {
  for (const double alpha : {0.01, 0.04, 0.09}) {
    SCOPED_TRACE(alpha);
    const glm::dvec3 f0(0.04, 0.3, 0.9);
    const BrdfTable mirror = ggx_table(glm::dvec3(0.0), f0, alpha), both = ggx_table({0.4, 0.1, 0.02}, f0, alpha);
    const BrdfTables alone = compute_brdf_tables(mirror), tables = compute_brdf_tables(both);
    const std::vector<BrdfLobe> lobes = compute_lobes(both, tables);
    ASSERT_EQ(lobes.size(), tables.albedo.size());
    EXPECT_NEAR(mirror_roughness(lobes) / std::sqrt(alpha), 1.0, 0.12);
    for (const std::size_t i : {0u, 12u, 25u, 40u}) {
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(lobes[i].mirror_albedo[c] / alone.albedo[i][c], 1.0, 0.12) << i << " " << c;
      const double theta = static_cast<double>(i) / 63.0 * kHalfPi;
      const glm::dvec3 d = glm::normalize(glm::dvec3(lobes[i].mirror_direction));
      EXPECT_NEAR(std::acos(glm::dot(d, glm::dvec3(-std::sin(theta), 0.0, std::cos(theta)))), 0.0, 0.03 + alpha);
    }
  }
  const BrdfTable lambert = color_table([](double, double, double) { return glm::dvec3(0.5 / std::numbers::pi); });
  const std::vector<BrdfLobe> dull = compute_lobes(lambert, compute_brdf_tables(lambert));
  EXPECT_LT(dull[25].mirror_albedo.y, 1e-6f);
  EXPECT_GT(mirror_roughness(dull), 0.9f);
  const auto roughness_of = [](const char* name) {
    const BrdfTable table = builtin_uncached(name);
    return mirror_roughness(compute_lobes(table, compute_brdf_tables(table)));
  };
  EXPECT_LT(roughness_of("plastic-piano-black"), 0.2f);
  EXPECT_LT(roughness_of("metal-chrome"), 0.2f);
  EXPECT_GT(roughness_of("leather-black"), 0.3f);
  EXPECT_GT(roughness_of("rubber-black"), 0.3f);
}

TEST(GgxFit, RecoversItsOwnModel) {
  for (double alpha : {0.02, 0.1, 0.4}) {
    const glm::dvec3 diffuse(0.4, 0.1, 0.02), f0(0.04, 0.3, 0.9);
    const GgxFit fit = fit_ggx(ggx_table(diffuse, f0, alpha));
    EXPECT_NEAR(fit.alpha / alpha, 1.0, 0.08);
    for (int c = 0; c < 3; ++c) {
      EXPECT_NEAR(fit.diffuse[c], diffuse[c], 0.02);
      EXPECT_NEAR(fit.specular[c] / f0[c], 1.0, 0.15);
    }
    EXPECT_LT(fit.relative_error, 0.03f);
  }
}

TEST(GgxFit, LambertAndBlackAreValid) {
  const GgxFit lambert = fit_ggx(builtin_uncached("matte-white"));
  EXPECT_NEAR(lambert.diffuse.y, 0.8f, 0.05f);
  EXPECT_LT(lambert.relative_error, 0.05f);
  const GgxFit black = fit_ggx(color_table([](double, double, double) { return glm::dvec3(0.0); }));
  EXPECT_LT(black.diffuse.y + black.specular.y, 1e-3f);
  EXPECT_TRUE(std::isfinite(black.alpha + black.relative_error));
}

TEST(SgFit, RecoversItsOwnModel) {
  const glm::dvec3 diffuse(0.3, 0.1, 0.05);
  const BrdfTable table = color_table([&](double h, double, double) {
    const double c = std::cos(h) - 1.0;
    return diffuse / std::numbers::pi + glm::dvec3(2.0, 5.0, 1.0) * std::exp(20.0 * c) +
           glm::dvec3(80.0, 30.0, 100.0) * std::exp(800.0 * c);
  });
  const SgFit fit = fit_sg(table);
  EXPECT_LT(fit.relative_error, 0.01f);
  for (int channel = 0; channel < 3; ++channel) {
    EXPECT_NEAR(fit.diffuse[channel], diffuse[channel], 0.1 * diffuse[channel] + 0.01);
    for (double theta : {0.0, 0.02, 0.1, 0.4}) {
      double value = static_cast<double>(fit.diffuse[channel]) / std::numbers::pi;
      for (const SgFit::Lobe& lobe : fit.lobes) {
        value += static_cast<double>(lobe.amplitude[channel]) *
                 std::exp(static_cast<double>(lobe.sharpness[channel]) * (std::cos(theta) - 1.0));
      }
      const double expected = evaluate_brdf(table, {std::sin(theta), 0.0, std::cos(theta)},
                                            {std::sin(theta), 0.0, std::cos(theta)})[channel];
      EXPECT_NEAR(value / expected, 1.0, 0.05) << theta;
    }
  }
}

TEST(SgFit, BlackAndChromeAreValid) {
  const SgFit black = fit_sg(color_table([](double, double, double) { return glm::dvec3(0.0); }));
  EXPECT_EQ(black.lobes.size(), 3u);
  EXPECT_EQ(black.diffuse.y + black.lobes[0].amplitude.y, 0.0f);
  const SgFit chrome = fit_sg(builtin_uncached("metal-chrome"));
  EXPECT_GT(chrome.lobes[0].sharpness.y, 2000.0f);
  EXPECT_LT(chrome.relative_error, 0.8f);
  for (const SgFit::Lobe& lobe : chrome.lobes) {
    for (int c = 0; c < 3; ++c)
      EXPECT_TRUE(std::isfinite(lobe.amplitude[c]) && lobe.amplitude[c] >= 0.0f && lobe.sharpness[c] > 0.0f);
  }
}

/// A material with a metallic lobe is distinguished from a dull one; the SG fit is worst for the colour-changing paint.
TEST(Fits, ErrorsRankMaterials) {
  EXPECT_LT(fit_ggx(builtin_uncached("plastic-matte-grey")).relative_error, 0.15f);
  EXPECT_GT(fit_ggx(builtin_uncached("plastic-matte-grey")).alpha, 0.2f);
  EXPECT_LT(fit_ggx(builtin_uncached("metal-chrome")).alpha, 0.03f);
}

}  // namespace
