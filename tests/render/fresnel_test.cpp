#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "render/math/surface_formulas.h"

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

/// Compares with Stokes' sums in long double, whose precision compensates the cancellation in 1 - r^2 at grazing
/// incidence.
TEST(Fresnel, PaneKeepsItsDigitsFromGrazingToNormalIncidence) {
  std::mt19937 random(1);
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  for (int i = 0; i < 200000; ++i) {
    const float c = i % 2 ? unit(random) : std::pow(10.0f, -6.0f * unit(random));
    const float n = i % 5 == 0 ? 1.0f + std::pow(10.0f, -6.0f * unit(random)) : 1.0f + 2.0f * unit(random);
    const float inside = i % 3 == 0 ? 1.0f : i % 3 == 1 ? unit(random) : std::pow(10.0f, -6.0f * unit(random));
    const long double cos_i = c, index = n, t = inside;
    const long double b = std::sqrt(index * index - 1.0L + cos_i * cos_i);
    long double reflected = 0.0L, transmitted = 0.0L;
    for (const long double a : {cos_i, index * index * cos_i}) {
      const long double r = (a - b) * (a - b) / ((a + b) * (a + b)), q = 1.0L - r;
      reflected += 0.5L * (r + q * q * r * t * t / (1.0L - r * r * t * t));
      transmitted += 0.5L * q * q * t / (1.0L - r * r * t * t);
    }
    const glm::vec2 pane = shared::fresnel_pane(c, n, inside);
    const auto passed = static_cast<double>(transmitted), mirrored = static_cast<double>(reflected);
    ASSERT_NEAR(pane.y, passed, 4e-6 * passed) << c << " " << n << " " << inside;
    ASSERT_NEAR(pane.x, mirrored, 4e-6 * mirrored + 1e-7) << c << " " << n << " " << inside;
  }
  EXPECT_NEAR(shared::fresnel_pane(0.3f, 1.0f, 0.5f).y, 0.5f, 1e-6f);
  EXPECT_TRUE(std::isfinite(shared::fresnel_pane(0.0f, 1.0f, 0.0f).y));
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

/// Flat parallel faces: the second ray is parallel to the first, displaced by d sin(2 theta) / sqrt(n^2 - sin^2 theta).
TEST(Pane, SecondImageOfParallelFacesIsDisplaced) {
  constexpr float kThickness = 0.005f, kIndex = 1.52f;
  for (const float degrees : {5.0f, 30.0f, 45.0f, 60.0f, 70.0f, 85.0f}) {
    const float theta = degrees * 0.0174532925f;
    const glm::vec3 d(std::sin(theta), -std::cos(theta), 0.0f), n(0.0f, 1.0f, 0.0f);
    const shared::GhostRay ray = shared::pane_ghost(d, n, n, n, kIndex, kThickness);
    ASSERT_TRUE(ray.valid);
    EXPECT_LT(glm::length(ray.direction - glm::vec3(d.x, -d.y, 0.0f)), 1e-5f);
    EXPECT_NEAR(ray.offset.y, 0.0f, 1e-8f);
    const float beside = glm::length(glm::cross(ray.offset, ray.direction)), s = std::sin(theta);
    const float refracted = std::asin(s / kIndex);
    EXPECT_NEAR(beside, 2.0f * kThickness * std::tan(refracted) * std::cos(theta), 1e-7f);
    EXPECT_NEAR(beside, kThickness * std::sin(2.0f * theta) / std::sqrt(kIndex * kIndex - s * s), 1e-7f);
  }
}

/// A wedge of angle alpha rotates the second ray: sin(out) = n sin(theta' + 2 alpha), about 2 n alpha at normal
/// incidence.
TEST(Pane, SecondImageOfAWedgeIsRotated) {
  constexpr float kIndex = 1.52f;
  for (const float alpha : {1e-3f, -1e-3f, 0.01f})
    for (const float degrees : {0.0f, 20.0f, 60.0f}) {
      const float theta = degrees * 0.0174532925f;
      const glm::vec3 d(std::sin(theta), -std::cos(theta), 0.0f), n(0.0f, 1.0f, 0.0f);
      const glm::vec3 back(std::sin(alpha), std::cos(alpha), 0.0f);
      const shared::GhostRay ray = shared::pane_ghost(d, n, back, n, kIndex, 0.005f);
      ASSERT_TRUE(ray.valid);
      const double inside = std::asin(std::sin(theta) / kIndex) + 2.0 * static_cast<double>(alpha);
      const double out = std::asin(kIndex * std::sin(inside));
      EXPECT_NEAR(std::atan2(ray.direction.x, ray.direction.y), out, 2e-5);
      if (degrees == 0.0f) {
        EXPECT_NEAR(out, 2.0 * kIndex * alpha, 3.0 * std::abs(alpha * alpha));
      }
    }
}

TEST(Pane, FacesSumToThePane) {
  for (const float c : {0.01f, 0.3f, 0.7f, 1.0f})
    for (const float inside : {0.0f, 0.5f, 1.0f}) {
      const glm::vec2 faces = shared::fresnel_faces(c, 1.52f, inside);
      EXPECT_NEAR(faces.x + faces.y, shared::fresnel_pane(c, 1.52f, inside).x, 1e-6f);
      EXPECT_NEAR(faces.x, shared::fresnel_surface(c, 1.52f), 1e-7f);
      if (inside == 0.0f) {
        EXPECT_NEAR(faces.y, 0.0f, 0x1p-22f);  // rounding of both
      }
    }
}

/// All bounces between two faces, summed one by one in double.
TEST(Pane, FacesReflectAsSpecularSays) {
  std::mt19937 random(3);
  const auto number = [&](float low, float high) { return std::uniform_real_distribution<float>(low, high)(random); };
  for (int k = 0; k < 200; ++k) {
    const float c = number(0.02f, 1.0f), ior = number(1.0f, 2.5f), specular = k % 5 == 0 ? 0.0f : number(0.0f, 1.0f);
    const glm::vec3 color(number(0.0f, 1.0f), number(0.0f, 1.0f), number(0.0f, 3.0f));
    const glm::vec3 inside(number(0.0f, 1.0f), 1.0f, number(0.0f, 1.0f));
    const shared::PaneFaces faces = shared::pane_faces(ior, specular, color);
    const shared::PaneShares found = shared::pane_shares(c, faces, inside);
    glm::dvec2 largest(0.0);
    for (int i = 0; i < 3; ++i) {
      const double f0 = std::min(std::pow((ior - 1.0) / (ior + 1.0), 2.0) * static_cast<double>(color[i]), 0.999);
      const glm::dvec2 face(shared::fresnel_sp(1.0f, faces.index[i]));
      EXPECT_NEAR(face.x, f0, 1e-4);
      largest = glm::max(largest, glm::dvec2(shared::fresnel_sp(c, faces.index[i])) * static_cast<double>(specular));
    }
    for (int i = 0; i < 3; ++i) {
      double reflected = 0.0, transmitted = 0.0;
      for (int side = 0; side < 2; ++side) {
        const double r =
            static_cast<double>(shared::fresnel_sp(c, faces.index[i])[side]) * static_cast<double>(specular);
        const double passes = 1.0 - largest[side], in = static_cast<double>(inside[i]);
        double light = passes * in;
        reflected += 0.5 * r;
        for (int bounce = 0; bounce < 20000 && light > 1e-9; ++bounce, light *= r * in)
          (bounce % 2 == 0 ? transmitted : reflected) += 0.5 * light * passes;
      }
      EXPECT_NEAR(found.reflected[i], reflected, 2e-5) << c << " " << ior << " " << specular;
      EXPECT_NEAR(found.transmitted[i], transmitted, 2e-5) << c << " " << ior << " " << specular;
    }
  }
}

TEST(Pane, PlainFacesAreThoseOfTheIndex) {
  for (const float c : {0.1f, 0.5f, 1.0f}) {
    EXPECT_TRUE(shared::is_plain(shared::pane_faces(1.52f, 1.0f, glm::vec3(1.0f))));
    const shared::PaneShares all = shared::pane_shares(c, shared::plain_faces(1.52f), {1.0f, 0.5f, 0.0f});
    const shared::PaneShares plain = shared::plain_pane_shares(c, 1.52f, {1.0f, 0.5f, 0.0f});
    for (int i = 0; i < 3; ++i) {
      const glm::vec2 pane = shared::fresnel_pane(c, 1.52f, i == 0 ? 1.0f : i == 1 ? 0.5f : 0.0f);
      EXPECT_NEAR(all.reflected[i], pane.x, 2e-6f);
      EXPECT_NEAR(all.transmitted[i], pane.y, 2e-6f);
      EXPECT_EQ(plain.reflected[i], pane.x);
      EXPECT_EQ(plain.transmitted[i], pane.y);
    }
  }
  EXPECT_NEAR(shared::pane_shares(0.3f, shared::pane_faces(1.5f, 0.0f, glm::vec3(1.0f)), glm::vec3(1.0f)).transmitted.x,
              1.0f, 1e-6f);
  // An index of 0 reflects all (KHR_materials_ior).
  EXPECT_NEAR(shared::pane_faces(0.0f, 1.0f, glm::vec3(1.0f)).index.x, shared::index_of_f0(1.0f), 1.0f);
}

}  // namespace
}  // namespace maquette
