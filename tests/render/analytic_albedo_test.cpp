#include "render/materials/analytic_albedo.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

namespace maquette {
namespace {

shared::AnalyticMaterial material(float base, float metallic, float roughness) {
  return shared::make_analytic(glm::vec3(base), metallic, roughness, 1.5f, 1.0f, glm::vec3(1.0f), 0.0f, 0.0f,
                               glm::vec3(0.0f), 0.3f);
}

/// What is reflected of constant light, by quadrature over half vectors in double, where lobes are smooth.
double quadrature(const shared::AnalyticMaterial& m, float cosine) {
  const glm::vec3 wo(std::sqrt(1.0f - cosine * cosine), 0.0f, cosine);
  constexpr int kSide = 300;
  const double alpha = static_cast<double>(m.alpha);
  double sum = 0.0;
  for (int i = 0; i < kSide; ++i) {
    // tan^2 of the half vector's angle by the lobe's own distribution.
    const double u = (i + 0.5) / kSide, tan2 = alpha * alpha * u / (1.0 - u), z = 1.0 / std::sqrt(1.0 + tan2);
    for (int j = 0; j < kSide; ++j) {
      const double phi = 2.0 * std::numbers::pi * (j + 0.5) / kSide, r = std::sqrt(1.0 - z * z);
      const glm::vec3 h(r * std::cos(phi), r * std::sin(phi), z);
      const float d = glm::dot(wo, h);
      const glm::vec3 wi = 2.0f * d * h - wo;
      if (!(d > 0.0f) || !(wi.z > 0.0f)) continue;
      const double lobe = static_cast<double>(shared::evaluate_analytic(m, wi, wo).total.x) -
                          static_cast<double>(m.diffuse.x) / std::numbers::pi *
                              (1.0 - static_cast<double>(shared::base_fresnel(m, d).x));
      const double t = 1.0 + z * z * (alpha * alpha - 1.0),
                   density = alpha * alpha / (std::numbers::pi * t * t) * z / (4.0 * static_cast<double>(d));
      sum += lobe * static_cast<double>(wi.z) / density;
    }
  }
  double matte = 0.0;
  for (int i = 0; i < kSide; ++i) {
    const double u = (i + 0.5) / kSide;
    for (int j = 0; j < kSide; ++j) {
      const double phi = 2.0 * std::numbers::pi * (j + 0.5) / kSide;
      const glm::vec3 wi(std::sqrt(u) * std::cos(phi), std::sqrt(u) * std::sin(phi), std::sqrt(1.0 - u));
      const float d = glm::dot(wi, glm::normalize(wi + wo));
      matte += static_cast<double>(m.diffuse.x) * (1.0 - static_cast<double>(shared::base_fresnel(m, d).x));
    }
  }
  return (sum + matte) / (kSide * kSide);
}

TEST(AnalyticAlbedo, IsTheIntegralOfTheBrdf) {
  for (const float roughness : {0.1f, 0.3f, 0.5f, 0.8f, 1.0f}) {
    for (const float metallic : {0.0f, 1.0f}) {
      for (const float cosine : {0.15f, 0.3f, 0.5f, 0.8f, 1.0f}) {
        const shared::AnalyticMaterial m = material(0.2f, metallic, roughness);
        const shared::AnalyticAlbedo a = shared::analytic_albedo(m, cosine);
        const double true_one = quadrature(m, cosine), own = static_cast<double>(a.diffuse.x + a.mirror.x);
        EXPECT_NEAR(own, true_one, cosine >= 0.5f ? 0.007 : 0.03) << roughness << " " << metallic << " " << cosine;
      }
    }
  }
}

TEST(AnalyticAlbedo, OfAMirrorIsItsReflectance) {
  for (const float cosine : {0.02f, 0.1f, 0.5f, 1.0f}) {
    const shared::AnalyticMaterial m = material(0.3f, 1.0f, 0.0f);
    EXPECT_NEAR(shared::analytic_albedo(m, cosine).mirror.x, shared::base_fresnel(m, cosine).x, 0.01f) << cosine;
  }
}

TEST(AnalyticAlbedo, OfALobeIsInZeroToOne) {
  for (int i = 0; i <= 100; ++i) {
    for (int j = 0; j <= 100; ++j) {
      shared::AnalyticMaterial m = material(1.0f, j % 2 == 0 ? 0.0f : 1.0f, static_cast<float>(i) * 0.01f);
      m.coat = 1.0f;
      const shared::AnalyticAlbedo a = shared::analytic_albedo(m, static_cast<float>(j) * 0.01f);
      EXPECT_GE(std::min({a.diffuse.x, a.mirror.x, a.coat}), 0.0f) << i << " " << j;
      EXPECT_LE(std::max({a.diffuse.x, a.mirror.x, a.coat}), 1.0f) << i << " " << j;
    }
  }
}

}  // namespace
}  // namespace maquette
