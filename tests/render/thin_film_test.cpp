// Iridescence against the interference of a film computed wavelength by wavelength.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "render/math/shared_formulas.h"

namespace maquette {
namespace {

/// The CIE 1931 luminosity function. Source: Wyman et al. 2013, "Simple Analytic Approximations to the CIE XYZ Color
/// Matching Functions", Sec. 2.2.
double luminosity(double nm) {
  const auto bell = [&](double height, double middle, double below, double above) {
    const double t = (nm - middle) * (nm < middle ? below : above);
    return height * std::exp(-0.5 * t * t);
  };
  return bell(0.821, 568.8, 0.0213, 0.0247) + bell(0.286, 530.9, 0.0613, 0.0322);
}

/// Airy's formula for a dielectric film over a dielectric base at normal incidence, weighted by luminosity.
double film_luminance(double film, double base, double thickness_nm) {
  const double r12 = (1.0 - film) / (1.0 + film), r23 = (film - base) / (film + base);
  double sum = 0.0, weight = 0.0;
  for (double nm = 360.0; nm <= 830.0; nm += 0.5) {
    const double c = std::cos(4.0 * std::numbers::pi * film * thickness_nm / nm);
    const double reflected =
        (r12 * r12 + r23 * r23 + 2.0 * r12 * r23 * c) / (1.0 + r12 * r12 * r23 * r23 + 2.0 * r12 * r23 * c);
    sum += luminosity(nm) * reflected;
    weight += luminosity(nm);
  }
  return sum / weight;
}

TEST(ThinFilm, HasTheLuminanceOfTheSpectralSum) {
  for (const double film : {1.3, 1.45, 1.8})
    for (const double base : {1.5, 2.0, 3.0})
      for (double thickness_nm = 50.0; thickness_nm <= 800.0; thickness_nm += 25.0) {
        const double r = (base - 1.0) / (base + 1.0);
        const glm::vec3 found = shared::thin_film_fresnel(
            1.0f, static_cast<float>(film), static_cast<float>(thickness_nm), glm::vec3(static_cast<float>(r * r)));
        EXPECT_NEAR(luminance(found), film_luminance(film, base, thickness_nm), base > 2.0 ? 0.03 : 0.012)
            << film << " over " << base << ", " << thickness_nm << " nm";
      }
}

/// At other angles Schlick's term of the film's own face remains, so that materials drop a film of no thickness.
TEST(ThinFilm, WithoutThicknessIsTheBase) {
  for (const float f0 : {0.04f, 0.3f, 0.9f}) {
    const glm::vec3 found = shared::thin_film_fresnel(1.0f, 1.3f, 0.0f, glm::vec3(f0));
    for (int c = 0; c < 3; ++c) EXPECT_NEAR(found[c], f0, 0.01f);
  }
}

TEST(ThinFilm, StaysAReflectance) {
  for (float film = 1.0f; film < 3.0f; film += 0.1f)
    for (float thickness_nm = 0.0f; thickness_nm < 1500.0f; thickness_nm += 13.0f)
      for (const float cosine : {0.0f, 0.2f, 0.7f, 1.0f})
        for (const float f0 : {0.0f, 0.04f, 1.0f}) {
          const glm::vec3 found = shared::thin_film_fresnel(cosine, film, thickness_nm, glm::vec3(f0));
          for (int c = 0; c < 3; ++c) {
            EXPECT_TRUE(std::isfinite(found[c]));
            EXPECT_GE(found[c], 0.0f);
            EXPECT_LE(found[c], 1.35f);  // single channels lie outside Rec.709's gamut
          }
        }
}

}  // namespace
}  // namespace maquette
