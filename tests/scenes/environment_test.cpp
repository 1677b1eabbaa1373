#include "scenes/environment.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "scenes/angles.h"
#include "scenes/error.h"
#include "scenes/image_io.h"
#include "scenes/luminance.h"
#include "test_paths.h"
#include "tests/scenes/temporary_folder.h"

namespace maquette {
namespace {

using test::message_of;
using EnvironmentFile = test::TemporaryFolder;
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr float kInfinity = std::numeric_limits<float>::infinity();

double row_solid_angle(const Environment& e, int y) {
  return 2.0 * std::numbers::pi / e.width *
         (std::cos(std::numbers::pi * y / e.height) - std::cos(std::numbers::pi * (y + 1) / e.height));
}

bool is_sound(const Environment& e) {
  for (const glm::vec3& rgb : e.rgb)
    for (int c = 0; c < 3; ++c)
      if (!(rgb[c] >= 0.0f && std::isfinite(rgb[c]))) return false;
  return !e.rgb.empty() && e.rgb.size() == static_cast<std::size_t>(e.width) * static_cast<std::size_t>(e.height);
}

TEST(Latlong64, FollowsTheOpenExrConvention) {
  const auto near = [](const glm::dvec3& a, const glm::dvec3& b) { return glm::distance(a, b) < 1e-12; };
  EXPECT_TRUE(near(direction_from_latlong(4, 2, 8, 4), {0, 0, 1}));
  EXPECT_TRUE(near(direction_from_latlong(2, 2, 8, 4), {1, 0, 0}));
  EXPECT_TRUE(near(direction_from_latlong(3, 0, 8, 4), {0, 1, 0}));
  EXPECT_TRUE(near(direction_from_latlong(0, 2, 8, 4), {0, 0, -1}));
  for (double x = 0.25; x < 8; x += 0.5)
    for (double y = 0.25; y < 4; y += 0.5)
      EXPECT_LT(glm::distance(latlong_from_direction(direction_from_latlong(x, y, 8, 4), 8, 4), glm::dvec2(x, y)),
                1e-12);
}

TEST(Latlong64, EvaluationIsBilinearAndWraps) {
  Environment e;
  e.width = 8;
  e.height = 4;
  for (int i = 0; i < 32; ++i) e.rgb.emplace_back(static_cast<float>(i), 1.0f, 0.0f);
  const auto at = [&](double x, double y) { return evaluate_environment(e, direction_from_latlong(x, y, 8, 4)).x; };
  EXPECT_NEAR(at(3.5, 1.5), 11.0, 1e-9);
  EXPECT_NEAR(at(4.0, 1.5), 11.5, 1e-9);
  EXPECT_NEAR(at(4.0, 2.0), 15.5, 1e-9);
  EXPECT_NEAR(at(0.0, 1.5), 11.5, 1e-9);  // between columns 7 and 0 of row 1
  EXPECT_NEAR(at(8.0, 1.5), 11.5, 1e-9);
  EXPECT_NEAR(at(2.5, 0.1), 2.0, 1e-9);  // clamped at the pole
}

TEST_F(EnvironmentFile, BrokenTexelsBecomeTheMeanOfTheirNeighbours) {
  Image image(8, 4, 3, 2.0f);
  image.at(0, 1, 0) = kNan;
  image.at(1, 1, 1) = kInfinity;
  image.at(5, 3, 2) = -4.0f;
  image.at(3, 0, 0) = -kInfinity;
  save_exr(path("bad.exr"), image);
  const Environment e = load_environment(path("bad.exr"));
  ASSERT_TRUE(is_sound(e));
  for (const glm::vec3& rgb : e.rgb) EXPECT_EQ(rgb, glm::vec3(2.0f));
  ASSERT_EQ(e.warnings.size(), 1u);
  EXPECT_NE(e.warnings[0].find("4 texels"), std::string::npos);
  EXPECT_EQ(e.name, "bad.exr");
}

TEST_F(EnvironmentFile, AllBrokenIsBlack) {
  save_exr(path("nan.exr"), Image(8, 4, 3, kNan));
  const Environment e = load_environment(path("nan.exr"));
  for (const glm::vec3& rgb : e.rgb) EXPECT_EQ(rgb, glm::vec3(0.0f));
}

TEST_F(EnvironmentFile, OneTexelAndBlackAreFine) {
  save_exr(path("one.exr"), Image(1, 1, 3, 3.0f));
  const Environment one = load_environment(path("one.exr"));
  EXPECT_TRUE(one.warnings.empty());
  EXPECT_EQ(evaluate_environment(one, {0, 0, 1}), glm::dvec3(3.0));
  EXPECT_EQ(evaluate_environment(one, {0, -1, 0}), glm::dvec3(3.0));
  save_exr(path("black.exr"), Image(8, 4, 3));
  EXPECT_TRUE(is_sound(load_environment(path("black.exr"))));
}

TEST_F(EnvironmentFile, OtherAspectsAreReadWithAWarning) {
  save_exr(path("square.exr"), Image(8, 8, 3, 1.0f));
  ASSERT_EQ(load_environment(path("square.exr")).warnings.size(), 1u);
}

TEST_F(EnvironmentFile, AHugeMapIsReducedWithItsEnergyKept) {
  // 16400 is no multiple of the reduced width, so cells straddle texels. One very bright texel and one invalid texel.
  constexpr int kWidth = 16400;
  constexpr int kHeight = 8;
  Image image(kWidth, kHeight, 3, 1.0f);
  image.at(5000, 3, 0) = 1e6f;
  image.at(9000, 5, 1) = kNan;
  save_exr(path("huge.exr"), image);
  const Environment e = load_environment(path("huge.exr"));
  ASSERT_TRUE(is_sound(e));
  EXPECT_EQ(e.width, 8192);
  EXPECT_EQ(e.height, 4);
  ASSERT_FALSE(e.warnings.empty());
  EXPECT_NE(e.warnings[0].find("reduced from 16400 x 8"), std::string::npos);
  double mean = 0.0;
  for (const glm::vec3& rgb : e.rgb) mean += rgb.x;
  mean /= static_cast<double>(e.rgb.size());
  EXPECT_NEAR(mean, 1.0 + (1e6 - 1.0) / (kWidth * kHeight), 1e-3);
  for (const glm::vec3& rgb : e.rgb) EXPECT_EQ(rgb.y, 1.0f);
}

TEST_F(EnvironmentFile, HashIsOfTheContent) {
  Image image(8, 4, 3, 1.0f);
  save_exr(path("a.exr"), image);
  save_exr(path("b.exr"), image);
  image.at(2, 2, 2) = 1.5f;
  save_exr(path("c.exr"), image);
  const std::uint64_t a = load_environment(path("a.exr")).hash;
  EXPECT_EQ(a, load_environment(path("b.exr")).hash);
  EXPECT_NE(a, load_environment(path("c.exr")).hash);
}

TEST(BuiltinEnvironment, UnknownNamesListTheKnownOnes) {
  const std::string message = message_of<UsageError>([] { load_environment("builtin:moon"); });
  EXPECT_NE(message.find("builtin:clear-sky"), std::string::npos);
  EXPECT_NE(message.find("builtin:studio"), std::string::npos);
}

TEST(BuiltinEnvironment, ClearSkyHasPhysicalLight) {
  const Environment e = load_environment("builtin:clear-sky");
  ASSERT_TRUE(is_sound(e));
  EXPECT_TRUE(e.warnings.empty());
  double sky_lx = 0.0, sun_lx = 0.0, sky_mean = 0.0, peak = 0.0;
  for (int y = 0; y < e.height / 2; ++y) {
    for (int x = 0; x < e.width; ++x) {
      const double value = luminance(glm::dvec3(e.rgb[static_cast<std::size_t>(y * e.width + x)]));
      const double flux = value * row_solid_angle(e, y);
      peak = std::max(peak, value);
      const double up = direction_from_latlong(x + 0.5, y + 0.5, e.width, e.height).y;
      if (value > 1e6) {
        sun_lx += flux;
      } else {
        sky_lx += flux * up;
        sky_mean += flux / (2.0 * std::numbers::pi);
      }
    }
  }
  // The disc's direct normal illuminance equals the model's, whatever the grid; the sky is that of a clear day.
  EXPECT_NEAR(sun_lx, 127500.0 * std::exp(-0.21 / std::sin(radians(40.0))), 500.0);
  EXPECT_GT(sky_mean, 2000.0);
  EXPECT_LT(sky_mean, 12000.0);
  EXPECT_GT(sky_lx, 8000.0);
  EXPECT_LT(sky_lx, 30000.0);
  EXPECT_GT(peak, 1e4 * sky_mean);
  // Blue overhead, and a ground that reflects the incident light.
  const glm::dvec3 zenith = evaluate_environment(e, {0, 1, 0});
  EXPECT_GT(zenith.z, 1.3 * zenith.x);
  const double ground = luminance(evaluate_environment(e, {0, -1, 0}));
  EXPECT_NEAR(ground * std::numbers::pi / (sky_lx + sun_lx * std::sin(radians(40.0))), 0.155, 0.02);
}

TEST(BuiltinEnvironment, StudioIsDarkWithBrightBoxes) {
  const Environment e = load_environment("builtin:studio");
  ASSERT_TRUE(is_sound(e));
  EXPECT_GT(luminance(evaluate_environment(e, {0, 1, 0})), 5000.0);
  EXPECT_LT(luminance(evaluate_environment(e, glm::normalize(glm::dvec3(-1, 1.2, -2)))), 100.0);
  EXPECT_GT(luminance(evaluate_environment(e, {0, -1, 0})), 300.0);
}

TEST(RealEnvironment, GraceIsTheRightWayUp) {
  const std::string file = std::string(MAQUETTE_SOURCE_DIR) + "/../shared/data/environments/grace_latlong.exr";
  if (!std::filesystem::exists(file)) GTEST_SKIP() << file << " is absent";
  const Environment e = load_environment(file);
  EXPECT_EQ(e.width, 1024);
  EXPECT_EQ(e.height, 512);
  EXPECT_TRUE(is_sound(e));
}

}  // namespace
}  // namespace maquette
