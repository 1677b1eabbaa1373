#include <gtest/gtest.h>

#include <cmath>

#include "render/gl/context.h"
#include "render/reference/reference.h"
#include "render/renderer.h"
#include "scenes/error.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

FrameRequest request_for(int texels) {
  FrameRequest r;
  r.mode = "slf";
  r.width = 64;
  r.height = 48;
  r.settings.set("slf.texels", texels);
  r.settings.set("slf.paths", 2);
  r.settings.set("shading.visibility", std::string("none"));
  return r;
}

struct Drawn {
  Image picture;
  FrameStats stats;
};
Drawn draw(Renderer* renderer, const FrameRequest& request) {
  EXPECT_TRUE(renderer->finish_background_work(request));
  Drawn drawn;
  drawn.stats = renderer->render(request);
  drawn.picture = renderer->read_radiance();
  return drawn;
}

TEST(LightFieldMode, AConvexBodyUnderAConstantSkyShowsItsAlbedo) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  const glm::vec3 albedo(0.8f, 0.5f, 0.2f), sky(2.0f, 3.0f, 4.0f);
  renderer.set_scene(std::make_shared<Scene>(test::sphere_of(test::matte(albedo))));
  renderer.set_environment(test::constant_sky(sky));
  FrameRequest request = request_for(48);
  request.camera.eye = {0.3f, 0.4f, 4.0f};
  request.camera.fov_y_rad = 0.5f;
  for (const int clusters : {0, 4}) {
    request.settings.set("slf.clusters", clusters);
    const Drawn drawn = draw(&renderer, request);
    EXPECT_GT(drawn.stats.gpu_bytes.at("slf"), 0u);
    int covered = 0;
    for (int y = 0; y < request.height; ++y)
      for (int x = 0; x < request.width; ++x) {
        if (drawn.picture.at(x, y, 3) < 1.0f) continue;
        ++covered;
        // Facets cut a little of the hemisphere off where shading normals lean; the sphere has 128 quads an edge.
        for (int c = 0; c < 3; ++c)
          EXPECT_NEAR(drawn.picture.at(x, y, c), albedo[c] * sky[c], 0.005f * albedo[c] * sky[c]) << x << " " << y;
      }
    EXPECT_GT(covered, 800);
  }
  EXPECT_TRUE(take_gl_errors().empty());
}

/// Normals differ by 5 degrees from texel to texel: each is read in the direction in which it mirrors what the point
/// mirrors.
TEST(LightFieldMode, AHighlightOnACurvedBodyStaysWhole) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  Material metal;
  metal.metallic = 1.0f;
  metal.roughness = std::sqrt(0.3f);
  const auto scene = std::make_shared<Scene>(test::sphere_of(metal));
  auto sky = std::make_shared<Environment>();
  sky->width = 128;
  sky->height = 64;
  sky->rgb.assign(std::size_t{128} * 64, glm::vec3(0.2f));
  for (int y = 14; y < 24; ++y)
    for (int x = 50; x < 62; ++x)
      sky->rgb[static_cast<std::size_t>(y) * 128 + static_cast<std::size_t>(x)] = glm::vec3(30.0f);
  renderer.set_scene(scene);
  renderer.set_environment(sky);
  FrameRequest request = request_for(64);
  request.camera.eye = {0.3f, 0.4f, 4.0f};
  request.camera.fov_y_rad = 0.5f;
  request.settings.set("slf.paths", 8);
  ReferencePicture picture(
      build_path_scene({.scene = *scene, .environment = sky}),
      {.camera = request.camera, .width = request.width, .height = request.height, .seed = 0, .paths = {}});
  picture.add(160);
  const Image expected = picture.mean();
  for (const int clusters : {0, 128}) {  // stored, and compressed
    request.settings.set("slf.clusters", clusters);
    const Image image = draw(&renderer, request).picture;
    double squares = 0.0, light = 0.0;
    for (int y = 0; y < request.height; ++y)
      for (int x = 0; x < request.width; ++x) {
        if (expected.at(x, y, 3) < 1.0f || image.at(x, y, 3) < 1.0f) continue;
        squares += std::pow(static_cast<double>(image.at(x, y, 1) - expected.at(x, y, 1)), 2.0);
        light += std::pow(static_cast<double>(expected.at(x, y, 1)), 2.0);
      }
    EXPECT_LT(std::sqrt(squares / light), 0.018) << clusters << "; 0.026 with the direction to the eye";
  }
}

/// A box with a lamp, its back wall of two colours: interreflection, shadows and the seams between walls.
std::shared_ptr<Scene> lit_box() {
  auto scene = std::make_shared<Scene>(test::box_scene(5, 4, test::matte({0.6f, 0.5f, 0.4f})));
  Material glow = test::matte(glm::vec3(0.0f));
  glow.emissive = glm::vec3(12.0f, 10.0f, 8.0f);
  Material gloss;
  gloss.name = "gloss";
  gloss.roughness = std::sqrt(0.5f);
  gloss.base_color = glm::vec4(0.7f, 0.7f, 0.7f, 1.0f);
  scene->materials.push_back(glow);
  scene->materials.push_back(gloss);
  test::add(scene.get(), test::make_grid({-0.4f, 0.95f, -0.4f}, {0.8f, 0, 0}, {0, 0, 0.8f}, 1, 1), "lamp");
  test::add(scene.get(), test::make_grid({-0.5f, -0.6f, -0.6f}, {0.9f, 0, 0.2f}, {0, 0.7f, -0.2f}, 4, 2), "panel");
  return scene;
}

TEST(LightFieldMode, AgreesWithTheReferenceInABox) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  const auto scene = lit_box();
  const auto sky = test::constant_sky(0.1f);
  renderer.set_scene(scene);
  renderer.set_environment(sky);
  FrameRequest request = request_for(96);
  request.camera.eye = {0.1f, 0.0f, 0.9f};
  request.camera.target = {0.0f, -0.1f, -1.0f};
  request.camera.fov_y_rad = 1.2f;
  Image references[2];
  for (std::uint32_t k = 0; k < 2; ++k) {
    ReferencePicture picture(
        build_path_scene({.scene = *scene, .environment = sky}),
        {.camera = request.camera, .width = request.width, .height = request.height, .seed = k, .paths = {}});
    picture.add(64);
    references[k] = picture.mean();
  }
  for (const int clusters : {0, 32}) {
    request.settings.set("slf.clusters", clusters);
    const Drawn drawn = draw(&renderer, request);
    double squares = 0.0, light = 0.0;
    for (int y = 0; y < request.height; ++y)
      for (int x = 0; x < request.width; ++x)
        for (int c = 0; c < 3; ++c) {
          const double s = static_cast<double>(drawn.picture.at(x, y, c)),
                       a = static_cast<double>(references[0].at(x, y, c)),
                       b = static_cast<double>(references[1].at(x, y, c));
          if (a > 5.0) continue;  // the lamp itself
          squares += (s - a) * (s - b);
          light += 0.5 * (a + b);
        }
    const double count = 3.0 * request.width * request.height;
    EXPECT_LT(std::sqrt(std::max(squares, 0.0) / count) / (light / count), 0.06) << clusters;
  }
  EXPECT_TRUE(take_gl_errors().empty());
}

TEST(LightFieldMode, TheSecondRouteShowsWhatTheFirstStores) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  renderer.set_scene(lit_box());
  renderer.set_environment(test::constant_sky(0.1f));
  FrameRequest request = request_for(64);
  request.camera.eye = {0.1f, 0.0f, 0.9f};
  request.camera.target = {0.0f, -0.1f, -1.0f};
  request.camera.fov_y_rad = 1.2f;
  request.settings.set("slf.clusters", 0);
  const Image stored = draw(&renderer, request).picture;
  request.settings.set("slf.route", std::string("clusters"));
  const Image apart = draw(&renderer, request).picture;
  double squares = 0.0, light = 0.0;
  for (std::size_t i = 0; i < stored.data.size(); ++i) {
    if (i % 4 == 3 || stored.data[i] > 5.0f) continue;
    squares += std::pow(static_cast<double>(stored.data[i]) - static_cast<double>(apart.data[i]), 2.0);
    light += static_cast<double>(stored.data[i]);
  }
  const double count = 3.0 * request.width * request.height;
  EXPECT_LT(std::sqrt(squares / count) / (light / count), 0.05);
  EXPECT_GT(squares, 0.0);
  EXPECT_TRUE(take_gl_errors().empty());
}

// A matte wall sends as much light everywhere, so that the middle of its lumisphere is what the picture shows.
TEST(LightFieldMode, SaysWhatIsTooSpecularAndWhatWasExchanged) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  const auto scene = lit_box();
  renderer.set_scene(scene);
  renderer.set_environment(test::constant_sky(0.1f));
  FrameRequest request = request_for(64);
  request.camera.target = {0.0f, -0.1f, -1.0f};
  const auto notes = [&] {
    renderer.finish_background_work(request);
    const FrameStats stats = renderer.render(request);
    std::string all;
    for (const std::string& note : stats.status.own_bakes.at("slf").notes) all += note + "\n";
    return all;
  };
  EXPECT_EQ(notes(), "");
  renderer.set_material("gloss", "builtin:metal-chrome");
  const std::string told = notes();
  EXPECT_NE(told.find("too specular"), std::string::npos) << told;
  EXPECT_NE(told.find("since the bake exchanged"), std::string::npos) << told;
  EXPECT_NE(told.find("gloss"), std::string::npos) << told;
  renderer.set_material("gloss", "");
  EXPECT_EQ(notes(), "");
}

TEST(LightFieldMode, TellsWhatATexelStores) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  renderer.set_scene(lit_box());
  renderer.set_environment(test::constant_sky(0.1f));
  FrameRequest request = request_for(64);
  request.camera.eye = {0.1f, 0.0f, 0.9f};
  request.camera.target = {0.0f, -0.1f, -1.0f};
  request.camera.fov_y_rad = 1.2f;
  const auto picture_of = [](const PointReport& report, const std::string& name) -> const Image& {
    for (const PointReport::Picture& picture : report.pictures)
      if (picture.name == name) return picture.image;
    throw std::runtime_error("no picture " + name);
  };
  PointReport reports[2];
  for (const bool compressed : {false, true}) {
    request.settings.set("slf.clusters", compressed ? 8 : 0);
    request.settings.set("slf.components", 1);
    const Image shown = draw(&renderer, request).picture;
    const Pick pick = renderer.pick(5, 24);
    const std::optional<PointReport> report = renderer.describe(pick);
    ASSERT_TRUE(report.has_value());
    reports[compressed] = *report;
    const Image& drawn = picture_of(*report, "as drawn");
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(drawn.at(drawn.width / 2, drawn.height / 2, c), shown.at(5, 24, c), 0.08f * shown.at(5, 24, c))
          << compressed;
    const Image& difference = picture_of(*report, "difference");
    float largest = 0.0f;
    for (std::size_t i = 0; i < difference.data.size(); ++i)
      if (i % 4 != 3) largest = std::max(largest, difference.data[i]);
    EXPECT_EQ(largest > 0.0f, compressed);
  }
  // What leaves is computed anew where only codes are kept: the same.
  for (const char* name : {"arriving", "leaving"}) {
    const Image &a = picture_of(reports[0], name), &b = picture_of(reports[1], name);
    for (std::size_t i = 0; i < a.data.size(); ++i)
      ASSERT_NEAR(a.data[i], b.data[i], 1e-4f + 1e-3f * a.data[i]) << name;
  }
  EXPECT_FALSE(renderer.describe(Pick{}).has_value());
  request.mode = "splitsum";
  draw(&renderer, request);
  EXPECT_FALSE(renderer.describe(renderer.pick(5, 24)).has_value()) << "nothing is baked for this mode";
}

TEST(LightFieldMode, TellsHowItsErrorFollowsCompression) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  renderer.set_scene(lit_box());
  renderer.set_environment(test::constant_sky(0.1f));
  FrameRequest request = request_for(64);
  request.settings.set("slf.clusters", 8);
  request.settings.set("slf.components", 2);
  draw(&renderer, request);
  const CompressionTableJob job = renderer.compression_table();
  ASSERT_TRUE(job);
  double last = 0.0;
  const auto table = job(std::atomic<bool>{false}, [&](double p) {
    EXPECT_GE(p, last);
    last = p;
  });
  ASSERT_TRUE(table.has_value());
  ASSERT_EQ(table->errors.size(), table->clusters.size() * table->components.size());
  const auto at = [](const std::vector<int>& of, int wanted) {
    return static_cast<std::size_t>(std::find(of.begin(), of.end(), wanted) - of.begin());
  };
  const std::size_t one = at(table->clusters, 1), eight = at(table->clusters, 8), two = at(table->components, 2);
  // More of either is no worse.
  for (std::size_t c = 0; c < table->components.size(); ++c) EXPECT_LE(table->error(c, eight), table->error(c, one));
  for (std::size_t c = 1; c < table->components.size(); ++c) EXPECT_LE(table->error(c, one), table->error(c - 1, one));
  EXPECT_GT(table->error(two, one), 0.0);
  EXPECT_FALSE(job(std::atomic<bool>{true}, [](double) {}).has_value()) << "cancelled";
  request.mode = "splitsum";
  draw(&renderer, request);
  EXPECT_FALSE(renderer.compression_table()) << "nothing is baked for this mode";
}

TEST(LightFieldMode, StandsBesideOtherModesAndCostsNothingElsewhere) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  renderer.set_scene(lit_box());
  renderer.set_environment(test::constant_sky(1.0f));
  FrameRequest request = request_for(32);
  request.camera.eye = {0.1f, 0.0f, 0.9f};
  request.camera.target = {0.0f, -0.1f, -1.0f};
  request.mode = "splitsum";
  EXPECT_EQ(draw(&renderer, request).stats.gpu_bytes.count("slf"), 0u);
  request.part_modes = {{"panel", "slf"}};
  const Drawn both = draw(&renderer, request);
  EXPECT_GT(both.stats.gpu_bytes.at("slf"), 0u);
  const Image charts = renderer.read_debug_view("slf_charts");
  int inside = 0;
  for (int y = 0; y < request.height; ++y)
    for (int x = 0; x < request.width; ++x) inside += charts.at(x, y, 0) > 0.0f ? 1 : 0;
  EXPECT_GT(inside, 100);
  EXPECT_LT(inside, request.width * request.height / 2);
  for (const char* view : {"slf_texels", "slf_clusters", "slf_errors"}) renderer.read_debug_view(view);
  EXPECT_TRUE(take_gl_errors().empty());
}

TEST(LightFieldMode, MirroredRaysShowIt) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  auto scene = lit_box();
  Material chrome;
  chrome.name = "chrome";
  chrome.roughness = 0.0f;
  scene->materials.push_back(chrome);
  test::add(scene.get(), test::make_grid({-0.9f, -0.9f, 0.2f}, {0.6f, 0, 0}, {0, 0.6f, 0}, 1, 3), "mirror")->reflector =
      true;
  renderer.set_scene(scene);
  renderer.set_environment(test::constant_sky(1.0f));
  FrameRequest request = request_for(32);
  request.reflections = "raytraced";
  request.camera.eye = {-0.4f, -0.4f, 0.95f};
  request.camera.target = {-0.6f, -0.6f, 0.0f};
  const Drawn drawn = draw(&renderer, request);
  double light = 0.0;
  for (const float v : drawn.picture.data) {
    ASSERT_TRUE(std::isfinite(v));
    light += static_cast<double>(v);
  }
  EXPECT_GT(light, 0.0);
  EXPECT_TRUE(take_gl_errors().empty());
}

TEST(LightFieldMode, NormalMapsAreRefusedByName) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  auto scene = lit_box();
  scene->images.push_back(test::checkerboard());
  scene->materials[2].normal_texture.image = 0;
  renderer.set_scene(scene);
  renderer.set_environment(test::constant_sky(1.0f));
  try {
    renderer.finish_background_work(request_for(16));
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("gloss"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace maquette
