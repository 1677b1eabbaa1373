// The sun is sampled apart from the rest of the sky: its samples sum to the bilinear light of its texels.
#include "render/environment/sun.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "render/environment/environment_tables.h"
#include "render/environment/packed_sky.h"
#include "render/math/shared_formulas.h"
#include "scenes/luminance.h"

namespace maquette {
namespace {

Environment sky(int width, int height, float radiance) {
  Environment e;
  e.width = width;
  e.height = height;
  e.rgb.assign(static_cast<std::size_t>(width * height), glm::vec3(radiance));
  return e;
}
glm::vec3& texel(Environment& e, int x, int y) { return e.rgb[static_cast<std::size_t>(y * e.width + x)]; }

/// The integral of luminance times (1, direction) over the tents of texels that are missing in `rest`, on a grid of 64
/// x 64 per texel.
glm::dvec4 quadrature(const Environment& whole, const Environment& rest, int bias) {
  constexpr double kPi = std::numbers::pi;
  constexpr int kSide = 64;
  glm::dvec4 sum(0.0);
  for (int y = 0; y < whole.height; ++y)
    for (int x = 0; x < whole.width; ++x) {
      const auto k = static_cast<std::size_t>(y * whole.width + x);
      if (whole.rgb[k] == rest.rgb[k]) continue;
      const double l = luminance(glm::dvec3(shared::unpack_rgb9e5(shared::pack_rgb9e5(whole.rgb[k], bias), bias)));
      for (int j = 0; j < 2 * kSide; ++j)
        for (int i = 0; i < 2 * kSide; ++i) {
          const double a = (i + 0.5) / kSide - 1.0, b = (j + 0.5) / kSide - 1.0;
          const double longitude = kPi - 2.0 * kPi * (x + 0.5 + a) / whole.width;
          const double latitude = kPi * (0.5 - (y + 0.5 + b) / whole.height);
          const double area = 2.0 * kPi * kPi / (static_cast<double>(whole.width) * whole.height) / (kSide * kSide);
          const double w = l * (1.0 - std::abs(a)) * (1.0 - std::abs(b)) * std::cos(latitude) * area;
          sum += w * glm::dvec4(1.0, std::sin(longitude) * std::cos(latitude), std::sin(latitude),
                                std::cos(longitude) * std::cos(latitude));
        }
    }
  return sum;
}

std::optional<Sun> sun_of(const Environment& e, std::size_t samples = 4096) {
  return find_sun(e, compute_environment_tables(e).luminance_integral, packing_bias(e), samples);
}

void expect_quadrature(const Environment& e, const char* what) {
  const auto sun = sun_of(e);
  ASSERT_TRUE(sun.has_value()) << what;
  glm::dvec4 mean(0.0);
  for (const EnvironmentSample& s : sun->samples)
    mean += luminance(glm::dvec3(s.radiance)) * glm::dvec4(1.0, glm::dvec3(s.direction)) /
            static_cast<double>(sun->samples.size());
  const glm::dvec4 truth = quadrature(e, *sun->rest, packing_bias(e));
  for (int k = 0; k < 4; ++k) EXPECT_NEAR(mean[k], truth[k], 1e-3 * truth.x) << what << " " << k;
}

TEST(SunApart, SamplesAddUpToItsTexels) {
  expect_quadrature(load_environment("builtin:clear-sky"), "clear sky");
  Environment e = sky(512, 256, 1.0f);
  texel(e, 100, 80) = glm::vec3(1e6f, 9e5f, 7e5f);
  expect_quadrature(e, "a million times the sky");
  texel(e, 300, 200) = glm::vec3(4e5f);
  texel(e, 301, 200) = glm::vec3(6e5f);
  expect_quadrature(e, "two suns");
  Environment hot = sky(512, 256, 0.0f);
  texel(hot, 0, 128) = glm::vec3(5.0f, 1.0f, 0.5f);
  expect_quadrature(hot, "one hot texel at the seam, all else black");
}

TEST(SunApart, WhatIsLeftIsTheRest) {
  Environment e = sky(512, 256, 1.0f);
  texel(e, 100, 80) = glm::vec3(1e6f);
  const auto sun = sun_of(e);
  ASSERT_TRUE(sun.has_value());
  EXPECT_GT(sun->least_luminance, 1.0f);
  EXPECT_LT(sun->least_luminance, 1e6f);
  for (std::size_t i = 0; i < e.rgb.size(); ++i)
    EXPECT_EQ(sun->rest->rgb[i], e.rgb[i].x > 1.0f ? glm::vec3(0.0f) : e.rgb[i]);
  EXPECT_NEAR(sun->solid_angle_sr, 4.0 * std::numbers::pi * std::numbers::pi / (2.0 * 512 * 256), 0.6 * 1.5e-4);
}

TEST(SunApart, SeveralAreDistinguishedFromOne) {
  EXPECT_TRUE(sun_of(load_environment("builtin:clear-sky"))->compact);
  Environment e = sky(512, 256, 1.0f);
  texel(e, 511, 80) = texel(e, 0, 80) = glm::vec3(1e6f);  // on both sides of the seam
  EXPECT_TRUE(sun_of(e)->compact);
  texel(e, 300, 200) = glm::vec3(4e5f);
  EXPECT_FALSE(sun_of(e)->compact);
}

TEST(SunApart, SkiesWithoutOneHaveNone) {
  EXPECT_FALSE(sun_of(sky(64, 32, 0.0f)));
  EXPECT_FALSE(sun_of(sky(64, 32, 1.0f)));
  EXPECT_FALSE(sun_of(sky(1, 1, 1e6f)));
  EXPECT_FALSE(sun_of(load_environment("builtin:studio")));
  Environment e = sky(512, 256, 1e-3f);
  texel(e, 10, 0) = glm::vec3(1e9f);  // at the pole
  EXPECT_FALSE(sun_of(e));
  for (int k = 0; k < 60; ++k) texel(e, 100 + k % 10, 100 + k / 10) = glm::vec3(1e6f);
  texel(e, 10, 0) = glm::vec3(1e-3f);
  EXPECT_FALSE(sun_of(e));  // a lamp of many degrees
}

// Weighted by light: a dim edge hardly lowers it, and a sky without sun has none.
TEST(SunApart, MeanLuminanceIsThatOfItsLight) {
  const auto mean_of = [](const Environment& e) {
    return static_cast<double>(mean_sun_luminance(e, compute_environment_tables(e).luminance_integral));
  };
  Environment e = sky(256, 128, 1.0f);
  EXPECT_EQ(mean_of(e), 0.0);
  EXPECT_EQ(mean_of(sky(256, 128, 0.0f)), 0.0);
  texel(e, 80, 63) = texel(e, 80, 64) = glm::vec3(1e6f);
  EXPECT_NEAR(mean_of(e) / 1e6, 1.0, 1e-5);
  texel(e, 81, 63) = texel(e, 81, 64) = glm::vec3(5e5f);
  EXPECT_NEAR(mean_of(e) / 1e6, (1.0 + 0.25) / (1.0 + 0.5), 1e-5);
}

}  // namespace
}  // namespace maquette
