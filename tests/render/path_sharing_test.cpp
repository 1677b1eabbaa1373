// Light shared by the paths of a tile, against paths without sharing, where neighbouring pixels see different things.
#include "render/reference/path_sharing.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "render/reference/path_scene.h"
#include "scenes/brdf.h"
#include "tests/support/path_scenes.h"

namespace maquette::test {
namespace {

constexpr int kWidth = 8, kHeight = 4;

/// Four tiles on the floor of a room; x = 0 passes through the left ones.
PictureRequest floor_request(float fov_y_rad = 0.08f) {
  PictureRequest request;
  request.camera.eye = {0.0f, 0.4f, 0.8f};
  request.camera.target = {0.03f, -1.0f, 0.0f};
  request.camera.fov_y_rad = fov_y_rad;
  request.width = kWidth;
  request.height = kHeight;
  request.adaptive = false;
  return request;
}

glm::vec3 direction_through(const PathScene& scene, const PictureRequest& r, int x, int y) {
  const CameraFrame camera = make_camera_frame(r.camera, r.width, r.height, scene.bounds);
  const glm::vec2 ndc = 2.0f * (glm::vec2(x, y) + 0.5f) / glm::vec2(r.width, r.height) - 1.0f;
  return glm::normalize(camera.ray_through({ndc.x, -ndc.y}).direction);
}

/// A room that is open above and in front, with one matte material (0), under a sky with a lamp.
Scene room() { return box_scene(4, 1, matte({0.8f, 0.6f, 0.4f})); }
int add_material(Scene* scene, const Material& material) {
  scene->materials.push_back(material);
  return static_cast<int>(scene->materials.size()) - 1;
}
Material double_sided(Material m) {
  m.double_sided = true;
  return m;
}
/// Along x = 0, from the floor up.
Primitive partition(float height, int material) {
  Primitive p = quad({0.0f, -1.0f, 0.4f}, {0.0f, 0.0f, -1.4f}, {0.0f, height, 0.0f});
  p.material = material;
  return p;
}
Primitive wall_piece(const glm::vec3& origin, const glm::vec3& a, const glm::vec3& b, int material) {
  Primitive p = quad(origin, a, b);
  p.material = material;
  return p;
}

/// Compares every pixel, and all of them together, with single radiances, which share and learn nothing.
void expect_same_picture(const Scene& scene, int paths, const PictureRequest& request, double noise = 0.06) {
  const auto traced =
      build_path_scene({.scene = scene, .environment = sky_with_lamp({0.5f, 0.7f, 1.0f}, glm::vec3(300.0f))});
  ReferencePicture picture(traced, request);
  ASSERT_TRUE(picture.add(paths));
  const Image mean = picture.mean(), variance = picture.variance();
  constexpr int kRuns = 16;
  const int alone = 2 * paths;
  double sum = 0.0, sum_alone = 0.0, square = 0.0, spread = 0.0;
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      const glm::vec3 direction = direction_through(*traced, request, x, y);
      double expected = 0.0, own = 0.0;
      for (std::uint32_t run = 0; run < kRuns; ++run) {
        double value = 0.0;
        for (int i = 0; i < alone / kRuns; ++i)
          value += static_cast<double>(estimate_radiance(*traced, {}, request.camera.eye, direction,
                                                         1000u * static_cast<std::uint32_t>(y * kWidth + x) + run,
                                                         static_cast<std::uint32_t>(i))
                                           .y) *
                   kRuns / alone;
        expected += value / kRuns;
        own += value * value / kRuns;
      }
      own = std::max(own - expected * expected, 0.0) / (kRuns - 1) + static_cast<double>(variance.at(x, y, 1));
      const double seen = static_cast<double>(mean.at(x, y, 1));
      EXPECT_NEAR(seen, expected, 4.5 * std::sqrt(own) + 1e-6 * expected) << x << ", " << y;
      sum += seen;
      sum_alone += expected;
      square += (seen - expected) * (seen - expected);
      spread += own;
    }
  EXPECT_LT(square, 1.6 * spread);
  EXPECT_LT(std::sqrt(spread), noise * sum_alone / std::sqrt(kWidth * kHeight)) << "too noisy to tell";
  EXPECT_NEAR(sum / sum_alone, 1.0, 0.002 + 4.0 * std::sqrt(spread) / sum_alone);
}

/// With pixels close together, and with some far apart.
void expect_same(const Scene& scene, int paths, double noise = 0.06) {
  for (const float fov : {0.08f, 1.0f}) {
    SCOPED_TRACE(fov);
    expect_same_picture(scene, paths, floor_request(fov), noise);
  }
}

TEST(PathSharing, EmptyRoom) { expect_same(room(), 1024); }

/// What is visible from one side is hidden from the other: a red wall, and a lamp that lights one side only.
TEST(PathSharing, PartitionBetweenThePixels) {
  Scene scene = room();
  const int red = add_material(&scene, double_sided(matte({0.9f, 0.1f, 0.1f})));
  add(&scene, partition(1.5f, red));
  expect_same(scene, 2048);
}

TEST(PathSharing, LowEdgeAcrossTheTile) {
  Scene scene = room();
  const int white = add_material(&scene, double_sided(white_lambert()));
  add(&scene, partition(0.02f, white));
  expect_same(scene, 2048);
}

/// Metals, one nearly a mirror and one rougher, beside the matte floor in one tile, also seen by way of the walls.
TEST(PathSharing, MirrorBesideMatte) {
  for (const float roughness : {0.1f, 0.4f}) {
    Scene scene = room();
    Material metal;
    metal.base_color = glm::vec4(0.9f, 0.8f, 0.7f, 1.0f);
    metal.metallic = 1.0f;
    metal.roughness = roughness;
    const int shiny = add_material(&scene, metal);
    add(&scene, wall_piece({0.0f, -0.999f, 1.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -2.0f}, shiny));
    add(&scene, wall_piece({-0.999f, -1.0f, 1.0f}, {0.0f, 0.0f, -2.0f}, {0.0f, 2.0f, 0.0f}, shiny));
    expect_same(scene, 2048, 0.15);
  }
}

/// Coated walls: their glossy reflection depends on the viewer.
TEST(PathSharing, GlossySecondSurfaces) {
  Scene scene = room();
  Material& wall = scene.materials[0];
  wall.specular = 1.0f;
  wall.roughness = 0.3f;
  wall.clearcoat = 1.0f;
  wall.clearcoat_roughness = 0.2f;
  wall.sheen_color = glm::vec3(0.3f);
  expect_same(scene, 2048);
}

/// Panes and a translucent sheet between first and second surfaces, for some of the pixels.
TEST(PathSharing, ThinThingsBetween) {
  Material pane = clear_pane();
  pane.base_color = glm::vec4(0.5f, 0.8f, 0.9f, 1.0f);
  Material veil = matte({0.2f, 0.9f, 0.2f});
  veil.base_color.a = 0.5f;
  veil.alpha_mode = AlphaMode::blend;
  Material nothing = pane;  // transmits everything, but is still a pane
  nothing.base_color = glm::vec4(1.0f);
  nothing.ior = 1.0f;
  for (const Material& between : {double_sided(pane), double_sided(nothing), double_sided(veil)}) {
    Scene scene = room();
    const int thin = add_material(&scene, between);
    add(&scene, partition(1.2f, thin));
    add(&scene, wall_piece({-0.4f, -0.9f, 0.3f}, {0.38f, 0.0f, 0.0f}, {0.0f, 0.0f, -1.0f}, thin));
    expect_same(scene, 2048);
  }
}

Scene halved_floor(const glm::vec3& walls, const glm::vec3& left, const glm::vec3& right) {
  Scene scene = box_scene(4, 1, matte(walls));
  const int a = add_material(&scene, matte(left)), b = add_material(&scene, matte(right));
  add(&scene, wall_piece({-0.99f, -0.999f, 0.99f}, {0.99f, 0.0f, 0.0f}, {0.0f, 0.0f, -1.98f}, a));
  add(&scene, wall_piece({0.0f, -0.999f, 0.99f}, {0.99f, 0.0f, 0.0f}, {0.0f, 0.0f, -1.98f}, b));
  return scene;
}

/// A glowing sheet that is dim beside the sky gets shadow rays from some paths only, and others hit it by chance;
/// single radiances always send a shadow ray to it.
TEST(PathSharing, LampsThatAreDimBesideTheSky) {
  Scene scene = room();
  Material glowing;
  glowing.emissive = glm::vec3(0.1f, 0.3f, 0.1f);
  glowing.double_sided = true;
  const int lamp = add_material(&scene, glowing);
  add(&scene, wall_piece({-0.5f, -0.95f, -0.2f}, {1.0f, 0.0f, 0.0f}, {0.0f, 0.3f, 0.2f}, lamp));
  expect_same(scene, 8192, 0.1);
}

/// A path that contributes nothing to its own pixel may contribute to others.
TEST(PathSharing, PureColoursBesideEachOther) {
  expect_same(halved_floor({0.0f, 1.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, glm::vec3(1.0f)), 1024, 0.1);
}

/// Roulette by the weights of dark pixels alone would make bright neighbours noisier than without sharing.
TEST(PathSharing, DarkPixelsDoNotThinOutBrightOnes) {
  const Scene scene = halved_floor(glm::vec3(0.9f), glm::vec3(0.02f), glm::vec3(0.9f));
  expect_same(scene, 4096, 0.1);
  const auto traced =
      build_path_scene({.scene = scene, .environment = sky_with_lamp({0.5f, 0.7f, 1.0f}, glm::vec3(300.0f))});
  constexpr int kPaths = 512;
  ReferencePicture picture(traced, floor_request());
  ASSERT_TRUE(picture.add(kPaths));
  const Image mean = picture.mean(), variance = picture.variance();
  float brightest = 0.0f;
  for (int x = 0; x < kWidth; ++x) brightest = std::max(brightest, mean.at(x, 0, 1));
  for (int y = 0; y < kHeight; ++y)
    for (int x = 0; x < kWidth; ++x) {
      if (mean.at(x, y, 1) < 0.5f * brightest) continue;
      EXPECT_LT(std::sqrt(kPaths * variance.at(x, y, 1)), 1.2f * mean.at(x, y, 1)) << x << ", " << y;
    }
}

TEST(PathSharing, MeasuredSurfaces) {
  Scene scene = room();
  Material measured;
  measured.measured = "builtin:" + builtin_brdfs().front().name;
  const int table = add_material(&scene, measured);
  add(&scene, wall_piece({0.0f, -0.999f, 1.0f}, {1.0f, 0.0f, 0.0f}, {0.0f, 0.0f, -2.0f}, table));
  add(&scene, wall_piece({-0.999f, -1.0f, 1.0f}, {0.0f, 0.0f, -2.0f}, {0.0f, 2.0f, 0.0f}, table));
  expect_same(scene, 2048);
}

/// A lamp as second surface, which also scatters.
TEST(PathSharing, Emitters) {
  Scene scene = room();
  Material lamp = double_sided(matte(glm::vec3(0.7f)));
  lamp.emissive = {20.0f, 10.0f, 5.0f};
  const int shining = add_material(&scene, lamp);
  add(&scene, wall_piece({0.01f, -0.9f, -0.2f}, {0.0f, 0.0f, -0.2f}, {0.0f, 0.2f, 0.0f}, shining));
  expect_same(scene, 1024);
}

/// Normals far from their triangles' are changed to face the viewer, differently for each viewer.
TEST(PathSharing, LeaningNormals) {
  Scene scene = room();
  for (Mesh& mesh : scene.meshes)
    for (Primitive& p : mesh.primitives)
      for (std::size_t i = 0; i < p.normals.size(); ++i)
        p.normals[i] = glm::normalize(p.normals[i] + glm::vec3(0.0f, 1.5f, i % 2 == 0 ? 0.5f : -0.5f));
  expect_same(scene, 2048);
}

/// In a corner, second surfaces are arbitrarily near, and 1 over the squared distance is unbounded: still no pixel
/// stands out, and all are correct.
TEST(PathSharing, CornerMakesNoFireflies) {
  Scene scene = room();
  PictureRequest request = floor_request();
  request.camera.target = {-1.0f, -1.0f, -1.0f};
  request.camera.fov_y_rad = 1e-4f;
  expect_same_picture(scene, 1024, request);
  const auto traced = build_path_scene({.scene = scene, .environment = constant_sky(1.0f)});
  request.width = request.height = 32;
  ReferencePicture picture(traced, request);
  ASSERT_TRUE(picture.add(16));
  const Image mean = picture.mean();
  float most = 0.0f;
  double sum = 0.0;
  for (int y = 0; y < 32; ++y)
    for (int x = 0; x < 32; ++x) {
      most = std::max(most, mean.at(x, y, 1));
      sum += static_cast<double>(mean.at(x, y, 1)) / (32.0 * 32.0);
    }
  EXPECT_LT(static_cast<double>(most), 5.0 * sum);
}

/// A tile of pixels that see the same floor, against a single pixel: light from walls is most of the noise.
TEST(PathSharing, LeavesLessNoise) {
  const auto traced =
      build_path_scene({.scene = room(), .environment = sky_with_lamp(glm::vec3(0.0f), glm::vec3(300.0f))});
  PictureRequest request = floor_request();
  const auto variance = [&](int width, int height) {
    request.width = width;
    request.height = height;
    ReferencePicture picture(traced, request);
    picture.add(2048);
    const Image image = picture.variance();
    double sum = 0.0;
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x) sum += static_cast<double>(image.at(x, y, 1)) / (width * height);
    return sum;
  };
  EXPECT_LT(variance(4, 2), 0.7 * variance(1, 1));
}

}  // namespace
}  // namespace maquette::test
