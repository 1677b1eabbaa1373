#include "render/picture/tonemap.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "render/renderer.h"
#include "scenes/error.h"

namespace maquette {
namespace {

glm::vec3 map_one(const glm::vec3& rgb, float ev, const std::string& name) {
  Image image(1, 1, 3);
  for (int c = 0; c < 3; ++c) image.at(0, 0, c) = rgb[c];
  const Image result = tone_map(image, ev, name);
  return {result.at(0, 0, 0), result.at(0, 0, 1), result.at(0, 0, 2)};
}

double srgb(double v) { return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055; }

TEST(Tonemap, LinearIsExposureThenSrgb) {
  EXPECT_NEAR(map_one({0.25f, 0.001f, 4.0f}, 1.0f, "linear").x, srgb(0.5), 1e-6);
  EXPECT_NEAR(map_one({0.25f, 0.001f, 4.0f}, 1.0f, "linear").y, srgb(0.002), 1e-6);
  EXPECT_NEAR(map_one({0.25f, 0.001f, 4.0f}, 1.0f, "linear").z, 1.0, 1e-6);
}

TEST(Tonemap, KnownValues) {
  EXPECT_NEAR(map_one(glm::vec3(1.0f), 0.0f, "reinhard").x, srgb(0.5), 1e-6);
  // Khronos specification: below 0.8 - 0.04 a colour with its minimum at 0.04 or more only loses 0.04.
  EXPECT_NEAR(map_one({0.5f, 0.2f, 0.1f}, 0.0f, "pbr-neutral").x, srgb(0.46), 1e-6);
  // A base colour under white light that was encoded with the F90 offset is reproduced; peak compression computed by
  // hand.
  const double peak = 2.0 - 0.04, compressed = 1.0 - 0.24 * 0.24 / (peak + 0.24 - 0.76);
  EXPECT_NEAR(map_one(glm::vec3(2.0f), 0.0f, "pbr-neutral").x, srgb(compressed), 1e-6);
  // Hill's rational fit computed by hand for grey, which stays grey (rows of both matrices sum to 1).
  const double x = 0.18, fit = (x * (x + 0.0245786) - 0.000090537) / (x * (0.983729 * x + 0.4329510) + 0.238081);
  EXPECT_NEAR(map_one(glm::vec3(0.18f), 0.0f, "aces").x, srgb(fit), 2e-4);
  // AgX has its pivot at middle grey: half of a display of gamma 2.2.
  EXPECT_NEAR(map_one(glm::vec3(0.18f), 0.0f, "agx").y, srgb(std::pow(0.5, 2.2)), 0.01);
}

TEST(Tonemap, EveryCurveRisesFromBlackToWhiteAndKeepsGreyGrey) {
  for (const std::string& name : tonemap_names()) {
    float previous = -1.0f;
    for (float ev = -12.0f; ev <= 12.0f; ev += 0.25f) {
      const glm::vec3 out = map_one(glm::vec3(1.0f), ev, name);
      EXPECT_GE(out.y, previous - 2e-3f) << name << ' ' << ev;
      EXPECT_NEAR(out.x, out.y, 0.01f) << name;
      EXPECT_NEAR(out.z, out.y, 0.01f) << name;
      previous = out.y;
    }
    EXPECT_LT(map_one(glm::vec3(0.0f), 0.0f, name).y, 0.01f) << name;
    EXPECT_GT(map_one(glm::vec3(1e6f), 0.0f, name).y, 0.95f) << name;
  }
}

TEST(Tonemap, APixelIsTheMeanOfItsPointsOnTheDisplay) {
  Image points(4, 2, 4);
  for (int k = 0; k < 8; ++k)
    for (int c = 0; c < 4; ++c) points.at(k % 4, k / 4, c) = k % 4 == 0 ? 1000.0f : 0.1f;
  const Image pixels = tone_map(points, 0.0f, "linear", 2);
  ASSERT_EQ(pixels.width, 2);
  ASSERT_EQ(pixels.height, 1);
  EXPECT_NEAR(pixels.at(0, 0, 0), srgb(0.5 * 1.0 + 0.5 * 0.1), 1e-6);
  EXPECT_NEAR(pixels.at(1, 0, 2), srgb(0.1), 1e-6);
  EXPECT_NEAR(pixels.at(0, 0, 3), 0.5 * 1.0 + 0.5 * 0.1, 1e-6);
}

TEST(Tonemap, BrokenPixelsStayInRange) {
  constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
  constexpr float kInfinity = std::numeric_limits<float>::infinity();
  for (const std::string& name : tonemap_names()) {
    for (const glm::vec3& rgb : {glm::vec3(kNan, 1, 1), glm::vec3(kInfinity), glm::vec3(-5.0f, 0.2f, kInfinity),
                                 glm::vec3(3e38f, 0, 0), glm::vec3(-kInfinity)}) {
      const glm::vec3 out = map_one(rgb, 3.0f, name);
      for (int c = 0; c < 3; ++c) EXPECT_TRUE(out[c] >= 0.0f && out[c] <= 1.0f) << name << ' ' << out[c];
    }
  }
}

TEST(Tonemap, AlphaIsKeptAndUnknownNamesAreNamed) {
  Image image(1, 1, 4, 0.5f);
  EXPECT_EQ(tone_map(image, 2.0f, "agx").at(0, 0, 3), 0.5f);
  try {
    tone_map(image, 0.0f, "filmic");
    ADD_FAILURE();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("pbr-neutral"), std::string::npos);
  }
}

TEST(Exposure, ALitGreyIsWellExposedUnderAnyLight) {
  Environment uniform;
  uniform.width = 32;
  uniform.height = 16;
  uniform.rgb.assign(512, glm::vec3(1.0f));
  const double ev = static_cast<double>(suggest_exposure_ev(uniform));
  // A white sky must not be overexposed, nor a grey in it dark.
  EXPECT_LT(std::exp2(ev), 1.0);
  EXPECT_GT(std::exp2(ev), 0.3);
  for (glm::vec3& rgb : uniform.rgb) rgb *= 1024.0f;
  EXPECT_NEAR(suggest_exposure_ev(uniform), ev - 10.0, 1e-4);
  for (glm::vec3& rgb : uniform.rgb) rgb = glm::vec3(0.0f);
  EXPECT_EQ(suggest_exposure_ev(uniform), 0.0f);
}

TEST(Exposure, BuiltinsGiveAMiddleTone) {
  for (const char* name : {"builtin:clear-sky", "builtin:studio"}) {
    const Environment e = load_environment(name);
    const double exposure = std::exp2(static_cast<double>(suggest_exposure_ev(e)));
    // Sideways irradiance of a grey card, by brute force.
    double irradiance = 0.0;
    for (int y = 0; y < e.height; ++y) {
      for (int x = 0; x < e.width; ++x) {
        const glm::dvec3 d = direction_from_latlong(x + 0.5, y + 0.5, e.width, e.height);
        const double solid_angle = 2.0 * 3.14159265 / e.width * 3.14159265 / e.height * std::sqrt(1.0 - d.y * d.y);
        irradiance +=
            std::max(d.y, 0.0) * solid_angle * static_cast<double>(e.rgb[static_cast<std::size_t>(y * e.width + x)].y);
      }
    }
    const double grey = exposure * 0.18 * irradiance / 3.14159265;
    EXPECT_GT(grey, 0.06) << name;
    EXPECT_LT(grey, 0.45) << name;
  }
}

TEST(Exposure, TheMiddleWeighsMore) {
  Image picture(32, 32, 4, 1.0f);
  const auto with_bright = [&](int first) {
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x)
        for (int c = 0; c < 3; ++c)
          picture.at(x, y, c) = x >= first && x < first + 8 && y >= first && y < first + 8 ? 0.3f : 0.01f;
    return meter_exposure_ev(picture, 0.0f);
  };
  EXPECT_LT(with_bright(12), with_bright(0) - 0.3f);
}

TEST(Exposure, MeteringBrightensDarkPicturesByAtMostFiveStopsAndDimsGlare) {
  Image picture(4, 4, 4, 1.0f);
  const auto fill = [&](float v) {
    for (std::size_t i = 0; i < picture.data.size(); ++i) picture.data[i] = i % 4 == 3 ? 1.0f : v;
  };
  fill(0.25f);
  EXPECT_FLOAT_EQ(meter_exposure_ev(picture, 0.0f), 0.0f);
  fill(0.046f);
  EXPECT_NEAR(meter_exposure_ev(picture, 0.0f), std::log2(0.1f / 0.05f), 1e-4f);
  fill(0.0f);
  EXPECT_NEAR(meter_exposure_ev(picture, -2.0f), -2.0f + std::log2(0.1f / 0.004f), 1e-4f);
  fill(1e-4f);
  EXPECT_NEAR(meter_exposure_ev(picture, -20.0f), -20.0f + std::log2(0.1f / 0.004f), 1e-3f);
  fill(8.0f);  // lit by lamps, not by the environment
  EXPECT_NEAR(meter_exposure_ev(picture, 0.0f), std::log2(0.3f / 8.004f), 1e-4f);
  // Sky (alpha 0) and invalid pixels do not count.
  fill(0.12f);
  for (int x = 0; x < 4; ++x) picture.at(x, 0, 3) = picture.at(x, 0, 0) = 0.0f;
  picture.at(2, 2, 1) = std::numeric_limits<float>::quiet_NaN();
  EXPECT_FLOAT_EQ(meter_exposure_ev(picture, 1.0f), 1.0f);
  EXPECT_FLOAT_EQ(meter_exposure_ev(Image(), 1.0f), 1.0f);
}

}  // namespace
}  // namespace maquette
