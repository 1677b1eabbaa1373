// The path tracer against what is known in closed form, and against itself.
#include "render/reference/reference.h"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <atomic>
#include <chrono>
#include <cmath>
#include <thread>

#include "scenes/error.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

using test::constant_sky;
using test::sphere_of;
using test::white_lambert;

PictureRequest sphere_request(int side) {
  PictureRequest request;
  request.camera.eye = {0.0f, 0.0f, 3.0f};
  request.width = request.height = side;
  return request;
}

/// Mean of R, G and B over the pixels that show a surface.
double mean_of_surface(const Image& image) {
  double sum = 0.0;
  int count = 0;
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x) {
      if (image.at(x, y, 3) < 1.0f) continue;
      for (int c = 0; c < 3; ++c) sum += image.at(x, y, c);
      count += 3;
    }
  return sum / count;
}

TEST(Reference, WhiteSphereVanishesInAFurnace) {
  const Scene scene = sphere_of(white_lambert());
  for (const Transport transport : {Transport::full, Transport::direct}) {
    PictureRequest request = sphere_request(32);
    request.paths.transport = transport;
    ReferencePicture picture(build_path_scene({.scene = scene, .environment = constant_sky(1.0f)}), request);
    ASSERT_TRUE(picture.add(64));
    EXPECT_NEAR(mean_of_surface(picture.mean()), 1.0, 0.002);
  }
}

TEST(Reference, ClearPaneLosesNothing) {
  Material glass = test::clear_pane();
  glass.double_sided = true;
  const Scene scene = sphere_of(glass);
  for (const Transport transport : {Transport::full, Transport::direct}) {
    PictureRequest request = sphere_request(32);
    request.paths.transport = transport;
    ReferencePicture picture(
        build_path_scene({.scene = scene, .environment = constant_sky(glm::vec3(2.0f, 1.0f, 0.5f))}), request);
    ASSERT_TRUE(picture.add(4));
    const Image mean = picture.mean();
    double sum = 0.0;
    for (int y = 0; y < 32; ++y)
      for (int x = 0; x < 32; ++x) sum += mean.at(x, y, 0);
    EXPECT_NEAR(sum / 1024.0, 2.0, 0.01);
    EXPECT_EQ(mean.at(16, 16, 3), 0.0f) << "only sky behind the pane";
  }
}

TEST(Reference, EnvironmentScaleAndAlphaHold) {
  const Scene scene = sphere_of(white_lambert());
  PictureRequest request = sphere_request(16);
  request.paths.env_scale = 7.0f;
  ReferencePicture picture(build_path_scene({.scene = scene, .environment = constant_sky(1.0f)}), request);
  picture.add(64);
  const Image mean = picture.mean();
  EXPECT_EQ(mean.at(0, 0, 3), 0.0f);
  EXPECT_NEAR(mean.at(0, 0, 0), 7.0f, 1e-4);
  EXPECT_EQ(mean.at(8, 8, 3), 1.0f);
  EXPECT_NEAR(mean.at(8, 8, 0), 7.0f, 0.2);
}

TEST(Reference, SameForAnyThreadCountAndAnyPortions) {
  const Scene scene = load_scene("builtin:cornell");
  const auto traced = build_path_scene({.scene = scene, .environment = constant_sky(1.0f)});
  PictureRequest request = sphere_request(24);
  request.msaa = 4;
  request.seed = 11;
  ReferencePicture all(traced, request), parts(traced, request);
  all.add(8);
  {
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    parts.add(3);
    parts.add(5);
  }
  EXPECT_EQ(all.mean().data, parts.mean().data);
  request.seed = 12;
  ReferencePicture other(traced, request);
  other.add(8);
  EXPECT_NE(all.mean().data, other.mean().data);
}

TEST(Reference, StopsAtOnceAndContinuesWhereItStopped) {
  const Scene scene = load_scene("builtin:cornell");
  const auto traced = build_path_scene({.scene = scene, .environment = constant_sky(1.0f)});
  ReferencePicture stopped(traced, sphere_request(32)), whole(traced, sphere_request(32));
  std::stop_source source;
  const std::jthread later([&] { source.request_stop(); });
  EXPECT_FALSE(stopped.add(1 << 20, source.get_token())) << "a million paths a pixel cannot have been traced";
  std::stop_source at_once;
  at_once.request_stop();
  ReferencePicture none(traced, sphere_request(32));
  EXPECT_FALSE(none.add(4, at_once.get_token()));
  EXPECT_EQ(none.samples(), 0);
  EXPECT_TRUE(none.add(4));
  whole.add(4);
  EXPECT_EQ(none.mean().data, whole.mean().data);
}

/// Large enough that guides are trained before the first path: the picture is the same whenever the training is
/// stopped.
TEST(Reference, TrainingContinuesWhereItStopped) {
  const auto traced = build_path_scene({.scene = load_scene("builtin:cornell"), .environment = constant_sky(1.0f)});
  ReferencePicture stopped(traced, sphere_request(128)), whole(traced, sphere_request(128));
  for (const int steps : {0, 1, 2, 4}) {
    std::stop_source source;
    if (steps == 0) source.request_stop();
    std::atomic<int> done = 0;
    const auto stop = [&](double) {
      if (++done == steps) source.request_stop();
    };
    EXPECT_FALSE(stopped.add(1 - stopped.samples(), source.get_token(), stop)) << steps;
  }
  EXPECT_TRUE(stopped.add(1 - stopped.samples()));
  whole.add(1);
  EXPECT_EQ(stopped.mean().data, whole.mean().data);
  EXPECT_EQ(stopped.counts().paths, 128u * 128u) << "training paths are left out";
}

/// Against pictures that are too small for training, over the same area: equal within the noise of both.
TEST(Reference, TrainingIsUnbiased) {
  const auto traced = build_path_scene({.scene = load_scene("builtin:cornell"), .environment = constant_sky(1.0f)});
  constexpr int kSeeds = 8;
  double mean[2] = {0.0, 0.0}, square[2] = {0.0, 0.0};
  for (std::uint32_t seed = 0; seed < kSeeds; ++seed)
    for (std::size_t k = 0; k < 2; ++k) {
      PictureRequest request = sphere_request(k == 0 ? 128 : 120);
      request.camera.eye = {0.0f, 2.73f, 10.8f};
      request.camera.target = {0.0f, 2.73f, 0.0f};
      request.msaa = 16;  // anywhere in the pixel: the picture's mean is the same integral
      request.seed = seed;
      ReferencePicture picture(traced, request);
      picture.add(2);
      const Image image = picture.mean();
      double sum = 0.0;
      for (int y = 0; y < image.height; ++y)
        for (int x = 0; x < image.width; ++x) sum += static_cast<double>(image.at(x, y, 1));
      sum /= static_cast<double>(image.width * image.height);
      mean[k] += sum / kSeeds;
      square[k] += sum * sum / kSeeds;
    }
  const auto error = [&](std::size_t k) {
    return std::sqrt(std::max(square[k] - mean[k] * mean[k], 0.0) / (kSeeds - 1));
  };
  EXPECT_NEAR(mean[0], mean[1], 4.0 * std::hypot(error(0), error(1)));
  EXPECT_LT(error(0), 0.002 * mean[0]) << "or the comparison says nothing";
}

/// A stopped picture has nearly the same number of paths at every pixel, in both transports.
TEST(Reference, StoppedPicturesHaveSimilarCounts) {
  const auto traced = build_path_scene({.scene = load_scene("builtin:cornell"), .environment = constant_sky(1.0f)});
  for (const Transport transport : {Transport::direct, Transport::full}) {
    PictureRequest request = sphere_request(32);
    request.paths.transport = transport;
    ReferencePicture picture(traced, request);
    std::stop_source source;
    EXPECT_FALSE(picture.add(1024, source.get_token(), [&](double share) {
      if (share >= 0.5) source.request_stop();
    }));
    EXPECT_GE(picture.samples(), 0.75 * static_cast<double>(picture.counts().paths) / (32.0 * 32.0));
  }
}

/// Adaptive counts do not change the mean: over many seeds, both ways agree within their noise.
TEST(Reference, AdaptivePathsAreUnbiased) {
  const auto traced = build_path_scene({.scene = load_scene("builtin:cornell"), .environment = constant_sky(0.0f)});
  PictureRequest request = sphere_request(16);
  request.camera.eye = {0.0f, 2.73f, 10.8f};
  request.camera.target = {0.0f, 2.73f, 0.0f};
  constexpr int kSeeds = 24;
  double mean[2] = {0.0, 0.0}, square[2] = {0.0, 0.0};
  for (int k = 0; k < 2 * kSeeds; ++k) {
    const bool adaptive = k % 2 == 1;
    request.adaptive = adaptive;
    request.seed = static_cast<std::uint32_t>(k);
    ReferencePicture picture(traced, request);
    picture.add(32);
    const double y = mean_of_surface(picture.mean());
    mean[adaptive] += y / kSeeds;
    square[adaptive] += y * y / kSeeds;
  }
  const double noise = std::sqrt((square[0] - mean[0] * mean[0] + square[1] - mean[1] * mean[1]) / (kSeeds - 1));
  EXPECT_NEAR(mean[1], mean[0], 4.0 * noise);
  EXPECT_LT(noise, 0.01 * mean[0]) << "too noisy to tell";
}

/// Where one half of a picture is noisy and the other is not, most paths soon go to the noisy half, and all pixels keep
/// some.
TEST(Reference, AdaptivePathsGoWhereTheNoiseIs) {
  const auto traced = build_path_scene({.scene = load_scene("builtin:cornell"), .environment = constant_sky(0.0f)});
  PictureRequest request = sphere_request(32);
  request.camera.eye = {0.0f, 2.73f, 10.8f};
  request.camera.target = {0.0f, 2.73f, 0.0f};
  const auto error = [&](bool adaptive, int count) {
    double square = 0.0, paths = 0.0;
    for (std::uint32_t seed = 0; seed < 8; ++seed) {
      request.adaptive = adaptive;
      request.seed = 2 * seed + (adaptive ? 1 : 0);
      ReferencePicture picture(traced, request);
      picture.add(count);
      square += std::pow(picture.relative_error(true), 2.0);
      paths += static_cast<double>(picture.counts().paths);
      EXPECT_EQ(picture.samples(), count);
    }
    return std::pair(std::sqrt(square), paths);
  };
  for (const int count : {8, 64}) {
    const auto [even, even_paths] = error(false, count);
    const auto [adaptive, adaptive_paths] = error(true, count);
    EXPECT_NEAR(adaptive_paths / even_paths, 1.0, 0.02) << count;
    EXPECT_LT(adaptive, 0.95 * even) << count;
  }
}

/// The deadline ends the first pass: every pixel still has a value, and the picture continues from there.
TEST(Reference, DeadlineWithinAPassLeavesAPicture) {
  const auto traced = build_path_scene({.scene = sphere_of(white_lambert()), .environment = constant_sky(1.0f)});
  ReferencePicture hurried(traced, sphere_request(64)), whole(traced, sphere_request(64));
  EXPECT_FALSE(hurried.add(16, {}, {}, std::chrono::steady_clock::now()));
  EXPECT_EQ(hurried.samples(), 0);
  EXPECT_EQ(hurried.counts().paths, 64u) << "one pixel of each block of 8 x 8";
  const Image coarse = hurried.mean();
  for (int y = 0; y < 64; ++y)
    for (int x = 0; x < 64; ++x) EXPECT_GT(coarse.at(x, y, 0), 0.0f) << x << ", " << y;
  EXPECT_TRUE(hurried.add(16));
  EXPECT_TRUE(whole.add(16));
  EXPECT_EQ(hurried.mean().data, whole.mean().data);
}

/// A lamp reflected by a pane onto a floor: the guide that finds it sooner does not change its brightness.
TEST(Reference, GuideToMirroredLampsIsUnbiased) {
  Scene scene = load_scene("builtin:plate");
  Material pane = test::clear_pane();
  pane.double_sided = true;
  scene.materials.push_back(pane);
  Primitive wall;
  wall.positions = {{-2, 0, -1}, {2, 0, -1}, {2, 3, -1}, {-2, 3, -1}};
  wall.normals.assign(4, {0, 0, 1});
  wall.indices = {0, 1, 2, 0, 2, 3};
  wall.material = static_cast<int>(scene.materials.size()) - 1;
  for (std::size_t m = 0; m + 1 < scene.materials.size(); ++m) scene.materials[m] = white_lambert();
  Mesh mesh;
  mesh.primitives.push_back(wall);
  scene.meshes.push_back(mesh);
  Node node;
  node.mesh = static_cast<int>(scene.meshes.size()) - 1;
  scene.nodes.push_back(node);
  scene.roots.push_back(static_cast<int>(scene.nodes.size()) - 1);
  auto sky = std::make_shared<Environment>();
  sky->width = 64;
  sky->height = 32;
  sky->rgb.assign(64 * 32, glm::vec3(0.01f));
  sky->rgb[9 * 64 + 32] = glm::vec3(100.0f);  // towards +z, 37 degrees up
  const auto traced = build_path_scene({.scene = scene, .environment = sky});
  PictureRequest request = sphere_request(24);
  request.camera.eye = {0.0f, 1.5f, 2.5f};
  request.camera.target = {0.0f, 0.0f, 0.0f};
  ReferencePicture picture(traced, request);
  picture.add(2048);
  // Without guides: single radiances along the same rays.
  double guided = 0.0, plain = 0.0, square = 0.0;
  const glm::vec3 direction = glm::normalize(request.camera.target - request.camera.eye);
  constexpr int kRuns = 64, kPaths = 2048;
  for (std::uint32_t run = 0; run < kRuns; ++run) {
    double sum = 0.0;
    for (std::uint32_t i = 0; i < kPaths; ++i)
      sum +=
          static_cast<double>(estimate_radiance(*traced, {}, request.camera.eye, direction, 100 + run, i).y) / kPaths;
    plain += sum / kRuns;
    square += sum * sum / kRuns;
  }
  const Image mean = picture.mean(), variance = picture.variance();
  double spread = 0.0;
  for (int y = 11; y < 13; ++y)
    for (int x = 11; x < 13; ++x) {
      guided += 0.25 * static_cast<double>(mean.at(x, y, 1));
      spread += static_cast<double>(variance.at(x, y, 1)) / 16.0;
    }
  const double noise = std::sqrt((square - plain * plain) / (kRuns - 1) + spread);
  EXPECT_NEAR(guided, plain, 4.0 * noise + 0.01 * plain);
  EXPECT_LT(noise, 0.03 * plain) << "too noisy to tell";
}

/// Rays that hit their own surface would be dark.
TEST(Reference, RaysLeaveTheirSurfaceAtEveryScale) {
  for (const float scale : {1e-6f, 1.0f, 1e6f}) {
    Scene scene = sphere_of(white_lambert());
    for (const int root : scene.roots) {
      glm::mat4& local = scene.nodes[static_cast<std::size_t>(root)].local;
      local = glm::mat4(glm::vec4(scale, 0, 0, 0), glm::vec4(0, scale, 0, 0), glm::vec4(0, 0, scale, 0),
                        glm::vec4(0, 0, 0, 1)) *
              local;
    }
    PictureRequest request = sphere_request(24);
    request.camera.eye = {0.0f, 0.0f, 3.0f * scale};
    ReferencePicture picture(build_path_scene({.scene = scene, .environment = constant_sky(1.0f)}), request);
    picture.add(32);
    EXPECT_NEAR(mean_of_surface(picture.mean()), 1.0, 0.004) << scale << " m";
  }
}

TEST(Reference, RaysLeaveAVeryLargeTriangle) {
  Scene scene;
  Mesh mesh;
  Primitive floor;
  floor.positions = {{-1e6f, 0.3f, -1e6f}, {1e6f, 0.3f, 1e6f}, {1e6f, 0.3f, -1e6f}, {-1e6f, 0.3f, 1e6f}};
  floor.indices = {0, 1, 2, 0, 3, 1};
  floor.material = 0;
  mesh.primitives.push_back(floor);
  scene.meshes.push_back(mesh);
  scene.materials.push_back(white_lambert());
  Node node;
  node.mesh = 0;
  scene.nodes.push_back(node);
  scene.roots.push_back(0);
  PictureRequest request = sphere_request(16);
  request.camera.eye = {0.1f, 2.0f, 0.2f};
  request.camera.target = {0.4f, 0.3f, 0.1f};
  request.camera.near_m = 0.01f;
  ReferencePicture picture(build_path_scene({.scene = scene, .environment = constant_sky(1.0f)}), request);
  picture.add(32);
  EXPECT_NEAR(mean_of_surface(picture.mean()), 1.0, 0.004);
}

TEST(Reference, LambertUnderALampAboveIsKnown) {
  // A small square lamp of radiance L and area A straight above at height h: L A / (pi h^2) times the albedo.
  Scene scene;
  Mesh mesh;
  Primitive floor, lamp;
  floor.positions = {{-1.0f, 0.0f, -1.0f}, {1.0f, 0.0f, 1.0f}, {1.0f, 0.0f, -1.0f}, {-1.0f, 0.0f, 1.0f}};
  floor.indices = {0, 1, 2, 0, 3, 1};
  floor.material = 0;
  const float s = 0.05f;
  lamp.positions = {{-s, 2.0f, -s}, {s, 2.0f, s}, {s, 2.0f, -s}, {-s, 2.0f, s}};
  lamp.indices = {0, 2, 1, 0, 1, 3};
  lamp.material = 1;
  mesh.primitives = {floor, lamp};
  scene.meshes.push_back(mesh);
  scene.materials = {white_lambert(), white_lambert()};
  scene.materials[1].emissive = glm::vec3(1000.0f);
  scene.materials[1].base_color = glm::vec4(0.0f, 0.0f, 0.0f, 1.0f);
  Node node;
  node.mesh = 0;
  scene.nodes.push_back(node);
  scene.roots.push_back(0);
  const auto traced = build_path_scene({.scene = scene, .environment = constant_sky(0.0f)});
  const glm::vec3 eye(0.3f, 1.0f, 0.0f);
  double sum = 0.0;
  for (std::uint32_t i = 0; i < 1024; ++i) sum += estimate_radiance(*traced, {}, eye, glm::normalize(-eye), 5, i).x;
  EXPECT_NEAR(sum / 1024.0, 1000.0 * 0.01 / (3.14159265 * 4.0), 0.01);
}

TEST(Reference, ErrorEstimateFallsWithTheRootOfTheSamples) {
  const Scene scene = load_scene("builtin:cornell");
  const auto traced = build_path_scene({.scene = scene, .environment = constant_sky(1.0f)});
  ReferencePicture picture(traced, sphere_request(32));
  EXPECT_EQ(picture.relative_error(), 0.0);
  picture.add(16);
  const double few = picture.relative_error();
  picture.add(240);
  EXPECT_GT(few, 0.0);
  EXPECT_NEAR(picture.relative_error() / few, 0.25, 0.08);
}

}  // namespace
}  // namespace maquette
