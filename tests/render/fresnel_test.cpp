#include <gtest/gtest.h>

#include <cmath>

#include "render/fresnel_shared.h"

namespace maquette {
namespace {

float cosine(double degrees) { return static_cast<float>(std::cos(degrees * 3.14159265358979 / 180.0)); }

TEST(Fresnel, MeetsTheKnownValuesOfWindowGlass) {
  struct Known {
    double degrees, surface, pane;
  };
  for (const Known& k : {Known{45.0, 0.053, 0.098}, {60.0, 0.093, 0.157}, {65.0, 0.124, 0.203}, {70.0, 0.175, 0.275}}) {
    EXPECT_NEAR(shared::fresnel_surface(cosine(k.degrees), 1.52f), k.surface, 6e-4) << k.degrees;
    EXPECT_NEAR(shared::fresnel_pane(cosine(k.degrees), 1.52f, 1.0f).x, k.pane, 6e-4) << k.degrees;
  }
}

TEST(Fresnel, ClosedFormsAtNormalIncidenceAndBrewsterAngle) {
  const float r0 = 0.52f * 0.52f / (2.52f * 2.52f);
  EXPECT_NEAR(shared::fresnel_surface(1.0f, 1.52f), r0, 1e-6f);
  EXPECT_NEAR(shared::fresnel_pane(1.0f, 1.52f, 1.0f).x, 2.0f * r0 / (1.0f + r0), 1e-6f);
  const float brewster = static_cast<float>(std::cos(std::atan(1.52)));
  EXPECT_NEAR(shared::fresnel_sp(brewster, 1.52f).y, 0.0f, 1e-10f);
}

TEST(Fresnel, ClearPaneKeepsEnergyAndTintedOneLosesIt) {
  for (double degrees = 0.0; degrees <= 90.0; degrees += 0.5) {
    const glm::vec2 clear = shared::fresnel_pane(cosine(degrees), 1.52f, 1.0f);
    ASSERT_NEAR(clear.x + clear.y, 1.0f, 2e-5f) << degrees;
    const glm::vec2 tinted = shared::fresnel_pane(cosine(degrees), 1.52f, 0.7f);
    ASSERT_LE(tinted.x + tinted.y, 1.0f) << degrees;
    ASSERT_TRUE(std::isfinite(tinted.x) && std::isfinite(tinted.y));
  }
  EXPECT_NEAR(shared::fresnel_pane(0.0f, 1.52f, 1.0f).x, 1.0f, 1e-5f);
}

/// The sum over bounces, term by term.
TEST(Fresnel, EqualsTheSeriesOfBounces) {
  for (double degrees : {10.0, 50.0, 80.0}) {
    const glm::vec2 r = shared::fresnel_sp(cosine(degrees), 1.6f);
    double reflected = 0.0, transmitted = 0.0;
    for (int k = 0; k < 2; ++k) {
      const double f = r[k], t = 0.8;
      reflected += 0.5 * f;
      double inside = (1.0 - f) * t;
      for (int bounce = 0; bounce < 200; ++bounce) {
        (bounce % 2 ? reflected : transmitted) += 0.5 * inside * (1.0 - f);
        inside *= f * t;
      }
    }
    const glm::vec2 pane = shared::fresnel_pane(cosine(degrees), 1.6f, 0.8f);
    EXPECT_NEAR(pane.x, reflected, 1e-6) << degrees;
    EXPECT_NEAR(pane.y, transmitted, 1e-6) << degrees;
  }
}

}  // namespace
}  // namespace maquette
