#include "viewer/error_meter.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "scenes/environment.h"
#include "scenes/scene.h"
#include "tests/support/waiting.h"
#include "viewer/budget_curve.h"
#include "viewer/session.h"

namespace maquette {
namespace {

TEST(PixelGrid, HitsPixelCentresOfAnySize) {
  for (const auto& [width, height] : {std::pair{656, 650}, {960, 440}, {333, 217}, {64, 9}, {1, 1}, {1921, 1081}}) {
    for (const int columns : {72, 200, 480}) {
      const PixelGrid grid = make_pixel_grid(width, height, columns);
      EXPECT_EQ(grid.factor % 2, 1);
      EXPECT_EQ((width - grid.width * grid.factor) % 2, 0) << width << ' ' << columns;
      EXPECT_EQ((height - grid.height * grid.factor) % 2, 0) << height << ' ' << columns;
      EXPECT_GE(grid.pixel_x(0), 0);
      EXPECT_GE(grid.pixel_y(0), 0);
      EXPECT_LT(grid.pixel_x(grid.width - 1), width);
      EXPECT_LT(grid.pixel_y(grid.height - 1), height);
    }
  }
}

TEST(PixelGrid, ItsCameraHasItsRaysThroughThePixels) {
  const PixelGrid grid = make_pixel_grid(640, 360, 72);
  CameraView camera;
  const double full = std::tan(0.5 * static_cast<double>(camera.fov_y_rad));
  const double part = std::tan(0.5 * static_cast<double>(grid_camera(camera, grid, 360).fov_y_rad));
  for (const int row : {0, 3, grid.height - 1}) {
    const double in_grid = part * (1.0 - 2.0 * (row + 0.5) / grid.height);
    const double in_picture = full * (1.0 - 2.0 * (grid.pixel_y(row) + 0.5) / 360.0);
    EXPECT_NEAR(in_grid, in_picture, 1e-6);
  }
  for (const int column : {0, 5, grid.width - 1}) {
    const double in_grid = part * grid.width / grid.height * (2.0 * (column + 0.5) / grid.width - 1.0);
    const double in_picture = full * 640.0 / 360.0 * (2.0 * (grid.pixel_x(column) + 0.5) / 640.0 - 1.0);
    EXPECT_NEAR(in_grid, in_picture, 1e-6);
  }
}

/// Halves with noise around 1, the picture `offset` above it.
GridReference noisy_reference(const PixelGrid& grid, float noise, std::uint32_t seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal(0.0f, noise);
  GridReference reference{grid, {}, 8};
  for (Image& half : reference.halves) {
    half = Image(grid.width, grid.height, 4, 1.0f);
    for (std::size_t i = 0; i < half.data.size(); ++i)
      if (i % 4 != 3) half.data[i] += normal(random);
  }
  return reference;
}

TEST(MeterError, IsRightOnAverageAndInItsInterval) {
  const PixelGrid grid = make_pixel_grid(300, 200, 60);
  const Image picture(300, 200, 4, 1.1f);
  int inside = 0;
  double sum = 0.0;
  constexpr int kTrials = 60;
  for (std::uint32_t seed = 0; seed < kTrials; ++seed) {
    const auto error = meter_error(picture, noisy_reference(grid, 0.5f, seed));
    ASSERT_TRUE(error);
    sum += error->error * error->error;
    inside += error->low <= 0.1 && error->high >= 0.1 ? 1 : 0;
  }
  EXPECT_NEAR(std::sqrt(sum / kTrials), 0.1, 0.02);  // the noise of 0.5 is no part of it
  EXPECT_GE(inside, 52);                             // 95 % of 60 are 57
}

/// The paths of a tile share light, and their noise is alike.
TEST(MeterError, NoiseOfATileIsOneNoise) {
  const PixelGrid grid = make_pixel_grid(300, 200, 60);
  const Image picture(300, 200, 4, 1.1f);
  int inside = 0;
  constexpr int kTrials = 100;
  for (std::uint32_t seed = 0; seed < kTrials; ++seed) {
    GridReference reference = noisy_reference(grid, 0.5f, seed);
    for (Image& half : reference.halves)
      for (int y = 0; y < grid.height; ++y)
        for (int x = 0; x < grid.width; ++x)
          for (int c = 0; c < 3; ++c) half.at(x, y, c) = half.at(x - x % kTileWidth, y - y % kTileHeight, c);
    const auto error = meter_error(picture, reference);
    ASSERT_TRUE(error);
    inside += error->low <= 0.1 && error->high >= 0.1 ? 1 : 0;
  }
  EXPECT_GE(inside, 89);  // 62 by pixels
}

TEST(MeterError, SkyAndDarknessHaveNone) {
  const PixelGrid grid = make_pixel_grid(90, 60, 30);
  EXPECT_FALSE(meter_error(Image(90, 60, 4, 0.0f), noisy_reference(grid, 0.0f, 1)));
  GridReference black = noisy_reference(grid, 0.0f, 1);
  for (Image& half : black.halves)
    for (std::size_t i = 0; i < half.data.size(); ++i)
      if (i % 4 != 3) half.data[i] = 0.0f;
  EXPECT_FALSE(meter_error(Image(90, 60, 4, 1.0f), black));
}

TEST(ErrorMeter, TracesAViewAndStopsAtOnce) {
  const auto scene = std::make_shared<Scene>(build_builtin_scene("sphere"));
  const auto environment = std::make_shared<const Environment>(load_environment("builtin:studio"));
  int built = 0;
  const auto make = [&] {
    ++built;
    return build_path_scene({*scene, environment, -1, nullptr, nullptr});
  };
  ErrorMeter meter;
  ErrorMeter::View view;
  view.camera = camera_of_options(*scene, {});
  view.width = 90;
  view.height = 60;
  EXPECT_TRUE(meter.watch(view, make));
  EXPECT_FALSE(meter.watch(view, make));  // it is at it
  std::uint64_t version = 0;
  const auto wait = [&] {
    test::comes_true([&] { return meter.newest(&version) || !meter.problem().empty(); });
    return meter.newest(&version);
  };
  const auto first = wait();
  ASSERT_TRUE(first) << meter.problem();
  EXPECT_EQ(first->halves[0].width, first->grid.width);
  EXPECT_GE(first->paths, 2);
  meter.cancel();
  EXPECT_FALSE(meter.newest(&version));
  view.camera.eye.x += 0.1f;
  EXPECT_TRUE(meter.watch(view, make));
  ASSERT_TRUE(wait()) << meter.problem();
  EXPECT_EQ(built, 1);  // the scene is the same
  meter.cancel();
  view.scene_revision = 1;
  meter.watch(view, []() -> std::shared_ptr<const PathScene> { throw std::runtime_error("no scene"); });
  EXPECT_FALSE(wait());
  EXPECT_EQ(meter.problem(), "no scene");
}

TEST(BudgetCurve, ReadsTheFewestSamplesLogLog) {
  const BudgetCurve curve{"here", {{4, 10.0, 0.4}, {16, 20.0, 0.2}, {64, 50.0, 0.1}}};
  std::string why;
  const auto choice = samples_for_budget(curve, 0.2 / std::sqrt(2.0), &why);
  ASSERT_TRUE(choice);
  EXPECT_EQ(choice->samples, 32);
  EXPECT_NEAR(choice->time_ms, 20.0 * std::sqrt(2.5), 1e-6);
  EXPECT_EQ(samples_for_budget(curve, 0.9, &why)->samples, 4);
  EXPECT_FALSE(samples_for_budget(curve, 0.05, &why));
  EXPECT_NE(why.find("10 % (64 samples)"), std::string::npos) << why;
  EXPECT_FALSE(samples_for_budget({"here", {{0, 10.0, 0.3}}}, 0.5, &why));
  EXPECT_NE(why.find("no setting"), std::string::npos) << why;
  EXPECT_FALSE(samples_for_budget({}, 0.5, &why));
}

TEST(BudgetCurve, SaysWhetherMoreSamplesWouldHelp) {
  std::string noise, flat, worse;
  EXPECT_FALSE(samples_for_budget({"here", {{4, 1.0, 0.4}, {16, 2.0, 0.2}, {64, 5.0, 0.1}}}, 0.05, &noise));
  EXPECT_FALSE(samples_for_budget({"here", {{4, 1.0, 0.4}, {16, 2.0, 0.34}, {64, 5.0, 0.33}}}, 0.05, &flat));
  EXPECT_FALSE(samples_for_budget({"here", {{4, 1.0, 0.4}, {16, 2.0, 0.32}, {64, 5.0, 0.35}}}, 0.05, &worse));
  EXPECT_NE(noise.find("would lower it further"), std::string::npos) << noise;
  EXPECT_NE(flat.find("hardly"), std::string::npos) << flat;
  EXPECT_NE(worse.find("hardly"), std::string::npos) << worse;
}

TEST(BudgetCurve, IsKeptByWhatTheSceneLooksLike) {
  Scene scene = build_builtin_scene("sphere");
  Environment environment = load_environment("builtin:studio");
  const std::uint64_t key = curves_key(scene, environment);
  store_curves(key, {{curve_name("uniform", true), {"a test", {{4, 1.0, 0.5}}}}});
  const BudgetCurves loaded = load_curves(key);
  ASSERT_EQ(loaded.size(), 1u);
  EXPECT_EQ(loaded.at("uniform/all").points[0].samples, 4);
  scene.materials[0].measured = "builtin:matte-white";
  EXPECT_NE(curves_key(scene, environment), key);
  environment.hash += 1;
  EXPECT_TRUE(load_curves(curves_key(scene, environment)).empty());
}

}  // namespace
}  // namespace maquette
