#include <gtest/gtest.h>

#include <cmath>
#include <random>
#include <set>

#include "scenes/brdf.h"
#include "scenes/brdf_models.h"
#include "scenes/error.h"

namespace {

using namespace maquette;

glm::dvec3 direction(double theta, double phi) {
  return {std::sin(theta) * std::cos(phi), std::sin(theta) * std::sin(phi), std::cos(theta)};
}
glm::dvec3 mirrored(const glm::dvec3& w) { return {-w.x, -w.y, w.z}; }

TEST(Fresnel, MatchesTextbookValues) {
  EXPECT_NEAR(fresnel_dielectric(1.0, 1.5), 0.04, 1e-12);
  EXPECT_NEAR(fresnel_dielectric(std::cos(60.0 * 3.14159265358979 / 180.0), 1.52), 0.0925, 1e-4);
  EXPECT_NEAR(fresnel_dielectric(0.0, 1.5), 1.0, 1e-12);
  EXPECT_EQ(fresnel_dielectric(0.3, 1.0 / 1.5), 1.0);             // total reflection
  EXPECT_NEAR(fresnel_conductor(1.0, 0.965, 6.4), 0.9139, 1e-3);  // ((n-1)^2 + k^2) / ((n+1)^2 + k^2)
  // Without absorption a conductor is a dielectric.
  for (double c : {0.1, 0.4, 0.9}) EXPECT_NEAR(fresnel_conductor(c, 1.5, 0.0), fresnel_dielectric(c, 1.5), 1e-12);
}

TEST(ThinFilm, IsGreyWithoutThicknessAndConservesEnergy) {
  for (const glm::vec3& value : thin_film_curve({1.4, 0.0, 0.3, -0.9, 1.5})) {
    const double expected = std::pow((0.3 - 0.9) / (1.0 - 0.27), 2);
    EXPECT_NEAR(value.x, expected, 1e-4);
    EXPECT_NEAR(value.z, expected, 1e-4);
  }
  for (double thickness : {100.0, 300.0, 600.0}) {
    for (const glm::vec3& value : thin_film_curve({1.38, thickness, 0.6, 0.85, 1.5})) {
      for (int c = 0; c < 3; ++c) {
        EXPECT_GE(value[c], 0.0f);
        EXPECT_LE(value[c], 1.0f);
      }
    }
  }
}

TEST(BrdfLibrary, NamesAreUniqueAndDescribed) {
  std::set<std::string> names;
  for (const BuiltinBrdf& brdf : builtin_brdfs()) {
    EXPECT_TRUE(names.insert(brdf.name).second) << brdf.name;
    EXPECT_FALSE(brdf.label.empty());
    EXPECT_GT(brdf.model.size(), 15u);
  }
  EXPECT_GE(names.size(), 16u);
}

TEST(BrdfLibrary, UnknownNameSuggestsTheNearest) {
  try {
    make_builtin_brdf("paint-solid-redd");
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("paint-solid-red"), std::string::npos) << error.what();
  }
  EXPECT_THROW(load_brdf("builtin:"), UsageError);
}

TEST(BrdfLibrary, TablesAreFinitePositiveAndReciprocal) {
  std::mt19937 random(2);
  std::uniform_real_distribution<double> unit(0.0, 1.0);
  std::set<std::uint64_t> hashes;
  for (const BuiltinBrdf& entry : builtin_brdfs()) {
    const BrdfTable table = load_brdf("builtin:" + entry.name);
    ASSERT_EQ(table.rgb.size(), static_cast<std::size_t>(kBrdfEntryCount));
    EXPECT_TRUE(hashes.insert(table.hash).second) << entry.name;
    for (const glm::vec3& value : table.rgb) {
      ASSERT_TRUE(std::isfinite(value.x + value.y + value.z)) << entry.name;
      ASSERT_GE(std::min({value.x, value.y, value.z}), 0.0f) << entry.name;
    }
    for (int i = 0; i < 50; ++i) {
      const glm::dvec3 wi = direction(1.5 * unit(random), 6.28 * unit(random));
      const glm::dvec3 wo = direction(1.5 * unit(random), 6.28 * unit(random));
      const glm::dvec3 a = evaluate_brdf(table, wi, wo), b = evaluate_brdf(table, wo, wi);
      EXPECT_NEAR(a.y, b.y, 1e-6 * (1.0 + a.y)) << entry.name;
    }
  }
}

TEST(BrdfLibrary, MatteWhiteIsLambert) {
  const BrdfTable table = make_builtin_brdf("matte-white");
  for (std::size_t i = 0; i < table.rgb.size(); i += 101) EXPECT_NEAR(table.rgb[i].y, 0.8 / 3.14159265, 1e-5);
}

TEST(BrdfLibrary, LooksLikeItsName) {
  const glm::dvec3 wo = direction(0.6, 0.0);
  const glm::dvec3 mirror = mirrored(wo), off = direction(0.3, 2.0);
  const auto at = [&](const char* name, const glm::dvec3& wi) {
    return evaluate_brdf(make_builtin_brdf(name), wi, wo);
  };
  EXPECT_GT(at("paint-solid-red", off).x, 5.0 * at("paint-solid-red", off).y);
  EXPECT_GT(at("paint-blue-metallic", off).z, 3.0 * at("paint-blue-metallic", off).x);
  for (const char* glossy : {"paint-solid-red", "paint-silver-metallic", "plastic-piano-black", "metal-chrome"}) {
    EXPECT_GT(at(glossy, mirror).y, 30.0) << glossy;
  }
  for (const char* dull : {"fabric-grey", "carpet-charcoal", "leather-black", "plastic-matte-grey", "rubber-black"}) {
    EXPECT_LT(at(dull, mirror).y, 1.0) << dull;
  }
}

/// The colour of the flakes changes with the angle: green or red at normal incidence, another hue towards grazing.
TEST(BrdfLibrary, FlopPaintsChangeHue) {
  const auto ratio = [](const char* name, double theta) {
    // 12 degrees beside the mirror direction, where the flakes reflect and not the coat.
    const glm::dvec3 f =
        evaluate_brdf(make_builtin_brdf(name), direction(theta + 0.2, 3.14159265), direction(theta, 0.0));
    return f / (f.x + f.y + f.z);
  };
  const glm::dvec3 green = ratio("paint-flop-green-violet", 0.1), violet = ratio("paint-flop-green-violet", 1.1);
  EXPECT_GT(green.y, green.x + 0.1);
  EXPECT_GT(violet.z, violet.y + 0.05);
  const glm::dvec3 first = ratio("paint-flop-gold-red", 0.1), second = ratio("paint-flop-gold-red", 1.1);
  EXPECT_GT(glm::length(first - second), 0.15);
}

}  // namespace
