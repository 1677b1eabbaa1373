// Extreme scales, shapes, angles, lights and counts; the figures are in docs/numerics/extremes.md.
#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <numbers>

#include "render/materials/brdf_tables.h"
#include "render/materials/symmetric_brdf.h"
#include "scenes/angles.h"
#include "tests/support/path_scenes.h"

namespace maquette::test {
namespace {

glm::vec3 to_floor(double degrees) {
  const double t = radians(degrees);
  return glm::vec3(glm::dvec3(-std::sin(t), -std::cos(t), 0.0));
}

/// A surface under a constant sky shows its albedo; a ray that hits the surface that it starts on shows less.
void expect_half(const Primitive& primitive, const glm::vec3& at, double height, const char* what) {
  const auto scene = trace(scene_of(primitive, matte(glm::vec3(0.5f))), constant_sky(1.0f));
  double worst = 0.0;
  for (const double degrees : {0.0, 45.0, 80.0, 89.0}) {
    const glm::vec3 d = to_floor(degrees);
    const glm::vec3 origin = at - d * static_cast<float>(height);
    const double seen = mean_radiance(*scene, {}, origin, d, 1024).mean.y;
    worst = std::max(worst, std::abs(seen - 0.5));
    EXPECT_NEAR(seen, 0.5, 1e-3) << what << " at " << degrees << " degrees";
  }
  std::printf("%s: largest difference %.6f\n", what, worst);
}

TEST(Extremes, RaysOnThinAndLargeTrianglesDoNotHitTheirOwnSurface) {
  const auto floor_at = [](float half, const glm::vec3& center) {
    return quad(center + glm::vec3(-half, 0, half), {2 * half, 0, 0}, {0, 0, -2 * half});
  };
  expect_half(floor_at(1e6f, glm::vec3(0.0f)), {0.3f, 0.0f, 0.2f}, 1.0, "triangles of 2e6 m, seen from 1 m");
  expect_half(floor_at(1e-6f, glm::vec3(0.0f)), {2e-7f, 0.0f, 1e-7f}, 1e-5, "triangles of 2e-6 m");
  expect_half(floor_at(1.0f, glm::vec3(1e4f, 1e4f, -1e4f)), {1e4f, 1e4f, -1e4f}, 0.5,
              "triangles of 2 m, 17 km from the origin");
  Primitive needle;
  needle.positions = {{-1.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 1e-6f}, {1.0f, 0.0f, -1e-6f}};
  needle.normals.assign(3, glm::vec3(0, 1, 0));
  needle.indices = {0, 1, 2};
  expect_half(needle, {0.9f, 0.0f, 0.0f}, 0.01, "a needle of 2 m by 2e-6 m");
  // Tilted, so that no coordinate of a hit is exact.
  Primitive tilted = quad({-300, -170, 90}, {600, 340.5f, 11}, {20, -50, -700});
  const glm::vec3 n = tilted.normals[0];
  const glm::vec3 at = tilted.positions[0] * 0.3f + tilted.positions[2] * 0.7f;
  const auto scene = trace(scene_of(tilted, matte(glm::vec3(0.5f))), constant_sky(1.0f));
  EXPECT_NEAR(mean_radiance(*scene, {}, at + 5.0f * n, -n, 4096).mean.y, 0.5, 5e-4);
}

/// The same box, scaled by 1e-6 and 1e6.
TEST(Extremes, SizeOfTheSceneDoesNotMatter) {
  const auto picture = [](float scale) {
    Scene scene = load_scene("builtin:cornell");
    for (const int root : scene.roots) {
      glm::mat4 grow(scale);
      grow[3][3] = 1.0f;
      scene.nodes[static_cast<std::size_t>(root)].local = grow * scene.nodes[static_cast<std::size_t>(root)].local;
    }
    PictureRequest request;
    request.camera = {.eye = glm::vec3(0.0f, 2.73f, 10.8f) * scale,
                      .target = glm::vec3(0.0f, 2.73f, 0.0f) * scale,
                      .fov_y_rad = 0.686f};
    request.width = request.height = 16;
    ReferencePicture p(trace(scene, constant_sky(0.1f)), request);
    p.add(64);
    return p.mean();
  };
  const Image one = picture(1.0f);
  for (const float scale : {1e-6f, 1e6f}) {
    const Image other = picture(scale);
    double difference = 0.0, sum = 0.0;
    for (std::size_t i = 0; i < one.data.size(); ++i) {
      ASSERT_TRUE(std::isfinite(other.data[i]));
      if (i % 4 == 3) continue;
      difference += static_cast<double>(other.data[i] - one.data[i]);
      sum += static_cast<double>(one.data[i]);
    }
    std::printf("box at scale %g: mean differs by %.5f\n", static_cast<double>(scale), difference / sum);
    EXPECT_NEAR(difference / sum, 0.0, 2e-3) << scale;
  }
}

/// Views down to 89.99 degrees: the albedo stays in [0, 1], and at the directions of the table of albedos it equals the
/// table. Between them, 1.4 degrees apart, the albedo of a lacquer falls by a third. The last direction, at the
/// horizon, is left out: the quadrature of the table gives that lacquer a fifth too little there.
TEST(Extremes, GrazingViewsOfMeasuredMaterials) {
  for (const char* name : {"paint-red-metallic", "metal-chrome", "leather-black", "matte-white"}) {
    Material material;
    material.measured = std::string("builtin:") + name;
    const auto scene = trace(scene_of(quad({-50, 0, 50}, {100, 0, 0}, {0, 0, -100}), material), constant_sky(1.0f));
    BrdfTables tables;
    compute_albedo(SymmetricBrdf(make_builtin_brdf(name)), tables);
    const auto look = [&](double degrees) {
      return mean_radiance(*scene, {}, -to_floor(degrees), to_floor(degrees), 8192);
    };
    for (const double degrees : {88.0, 89.0, 89.9, 89.99}) {
      const MeanRadiance seen = look(degrees);
      EXPECT_GT(seen.mean.y, 0.0) << name << " at " << degrees;
      EXPECT_LE(seen.mean.y, 1.0 + 5e-3 + 4.0 * seen.deviation) << name << " at " << degrees;
    }
    for (const int i : {60, 61, 62}) {
      const double degrees = 90.0 * i / (kAlbedoCount - 1);
      const MeanRadiance seen = look(degrees);
      const double expected = tables.albedo[static_cast<std::size_t>(i)].y;
      std::printf("%s at %.2f degrees: %.4f +- %.4f, table %.4f\n", name, degrees, seen.mean.y, seen.deviation,
                  expected);
      EXPECT_NEAR(seen.mean.y / expected, 1.0, 3e-3 + 4.0 * seen.deviation / expected) << name << " at " << degrees;
    }
  }
}

/// One texel of 1e6 over a sky of 1: irradiance of a floor is the sum over texels of the bilinear map.
TEST(Extremes, SunOfAMillionTimesTheSky) {
  constexpr int kW = 256, kH = 128, kX = 70, kY = 30;
  auto map = std::make_shared<Environment>();
  map->width = kW;
  map->height = kH;
  map->rgb.assign(kW * kH, glm::vec3(1.0f));
  map->rgb[kY * kW + kX] = glm::vec3(1e6f);
  const auto scene = trace(scene_of(quad({-50, 0, 50}, {100, 0, 0}, {0, 0, -100}), matte(glm::vec3(0.5f))), map);
  // The bilinear hat over the texel's neighbours, and the constant rest.
  double irradiance = std::numbers::pi;
  constexpr int kFine = 64;
  for (int i = 0; i < 2 * kFine; ++i)
    for (int j = 0; j < 2 * kFine; ++j) {
      const double u = (i + 0.5) / kFine - 1.0, v = (j + 0.5) / kFine - 1.0;
      const double latitude = std::numbers::pi * (0.5 - (kY + 0.5 + v) / kH);
      const double solid_angle =
          2.0 * std::numbers::pi / kW * std::numbers::pi / kH * std::cos(latitude) / (kFine * kFine);
      irradiance += (1e6 - 1.0) * (1.0 - std::abs(u)) * (1.0 - std::abs(v)) * std::sin(latitude) * solid_angle;
    }
  const double expected = 0.5 / std::numbers::pi * irradiance;
  const MeanRadiance seen = mean_radiance(*scene, {}, {0, 2, 0}, {0, -1, 0}, 8192);
  std::printf("sun of 1e6: %.5f of the sum, deviation %.5f\n", seen.mean.y / expected, seen.deviation / expected);
  EXPECT_NEAR(seen.mean.y / expected, 1.0, 2e-3 + 4.0 * seen.deviation / expected);
}

/// 2^19 paths in one pixel.
TEST(Extremes, AMillionSamplesAreSummedWithoutLoss) {
  const auto scene =
      trace(scene_of(quad({-50, 0, 50}, {100, 0, 0}, {0, 0, -100}), matte(glm::vec3(1.0f / 3.0f))), constant_sky(0.1f));
  PictureRequest request;
  request.camera = {.eye = {0, 3, 0}, .target = {0, 0, 0}, .up = {0, 0, 1}};
  request.width = request.height = 1;
  ReferencePicture picture(scene, request);
  ASSERT_TRUE(picture.add(1 << 19));
  // The remaining error is that of the sequence; a float sum of as many paths would be off by 1e-4.
  EXPECT_NEAR(picture.mean().at(0, 0, 1) / (0.1 / 3.0), 1.0, 1e-5);
}

}  // namespace
}  // namespace maquette::test
