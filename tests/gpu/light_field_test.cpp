#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "render/gl/context.h"
#include "render/reference/reference.h"
#include "render/renderer.h"
#include "scenes/btf/btf_file.h"
#include "scenes/error.h"
#include "tests/gpu/light_field_stage.h"
#include "tests/support/small_btf.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

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

/// Sunlit floor, shaded walls and a mirror in one table: all fit the half floats of the device.
TEST(LightFieldMode, TheSecondRouteHoldsSunlightBesideShade) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  const std::string cover = (std::filesystem::path(testing::TempDir()) / "second-route.exr").string();
  save_btf(cover, *test::small_btf(3, 4));
  renderer.set_scene(std::make_shared<Scene>(load_scene("builtin:seat")));
  renderer.set_material("Seat", cover);
  renderer.set_environment(std::make_shared<Environment>(load_environment("builtin:clear-sky")));
  FrameRequest request = request_for(32);
  request.settings.set("slf.directions", 8);
  request.camera.eye = {0.75f, 1.35f, 2.6f};
  request.camera.target = {0.5f, 1.14f, 1.66f};
  request.camera.fov_y_rad = 0.63f;
  const Image first = draw(&renderer, request).picture;
  request.settings.set("slf.route", std::string("clusters"));
  const Image second = draw(&renderer, request).picture;
  std::vector<float> ratios;
  for (std::size_t i = 0; i < first.data.size(); ++i)
    if (i % 4 == 1 && first.data[i] > 0.0f) ratios.push_back(second.data[i] / first.data[i]);
  ASSERT_GT(ratios.size(), 1000u);
  std::sort(ratios.begin(), ratios.end());
  EXPECT_GT(ratios[ratios.size() / 10], 0.5f) << "0 while all terms had one unit";
  EXPECT_LT(ratios[ratios.size() * 9 / 10], 2.0f);
  std::filesystem::remove(cover);
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
  EXPECT_NE(told.find("exchanged since the bake"), std::string::npos) << told;
  EXPECT_NE(told.find("gloss"), std::string::npos) << told;
  renderer.set_material("gloss", "");
  EXPECT_EQ(notes(), "");
}

/// Light that leaves is kept between compressions: not a moment longer than it is right.
TEST(LightFieldMode, WhatIsKeptMakesNoDifference) {
  const GlContext context = GlContext::create_headless();
  FrameRequest request = request_for(32);
  request.camera.target = {0.0f, -0.1f, -1.0f};
  const auto picture = [&](Renderer* renderer, int clusters, const std::string& gloss) {
    renderer->set_material("gloss", gloss);
    request.settings.set("slf.clusters", clusters);
    return draw(renderer, request).picture.data;
  };
  const auto open = [](Renderer* renderer) {
    renderer->set_scene(lit_box());
    renderer->set_environment(test::constant_sky(0.1f));
  };
  Renderer kept, fresh;
  open(&kept);
  open(&fresh);
  const auto first = picture(&kept, 0, "");
  picture(&kept, 4, "");
  const auto covered = picture(&kept, 4, "builtin:fabric-grey");
  EXPECT_EQ(covered, picture(&fresh, 4, "builtin:fabric-grey"));
  EXPECT_NE(covered, picture(&kept, 4, ""));
  EXPECT_EQ(first, picture(&kept, 0, ""));
  request.settings.set("slf.route", std::string("clusters"));  // which keeps what covers were compressed to
  const auto plain = picture(&kept, 4, ""), by_table = picture(&kept, 4, "builtin:fabric-grey");
  EXPECT_NE(plain, by_table);
  EXPECT_EQ(plain, picture(&kept, 4, ""));
  EXPECT_EQ(by_table, picture(&kept, 4, "builtin:fabric-grey"));
  EXPECT_EQ(by_table, picture(&fresh, 4, "builtin:fabric-grey"));
}

TEST(LightFieldMode, WhatIsHeldSaysWhatHasChanged) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  renderer.set_scene(lit_box());
  renderer.set_environment(test::constant_sky(0.1f));
  FrameRequest request = request_for(32);
  request.camera.target = {0.0f, -0.1f, -1.0f};
  const Image first = draw(&renderer, request).picture;
  request.settings.set("slf.run", std::string("hold"));
  const auto held = [&] {
    const BakeStatus status = renderer.render(request).status.own_bakes.at("slf");
    std::string all;
    for (const std::string& note : status.notes) all += note + "\n";
    EXPECT_NE(status.state, BakeState::running);
    return all;
  };
  EXPECT_EQ(held(), "");
  request.env_scale = 0.5f;
  std::string told = held();
  EXPECT_NE(told.find("under other light"), std::string::npos) << told;
  const Image shown = renderer.read_radiance();
  for (std::size_t i = 0; i < first.data.size(); ++i)
    if (first.data[i - i % 4 + 3] == 1.0f) {
      ASSERT_EQ(shown.data[i], first.data[i]) << "what is there is shown";
    }
  renderer.set_material("gloss", "builtin:fabric-grey");
  told = held();
  EXPECT_NE(told.find("as they were: gloss"), std::string::npos) << told;
  request.settings.set("slf.run", std::string("auto"));
  const Drawn made = draw(&renderer, request);
  EXPECT_NE(made.picture.data, first.data);
  for (const std::string& note : made.stats.status.own_bakes.at("slf").notes)
    EXPECT_NE(note.find("exchanged since the bake"), std::string::npos) << note;
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
