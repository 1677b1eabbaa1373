#include <gtest/gtest.h>

#include <glm/gtc/matrix_transform.hpp>

#include "render/frame/camera.h"
#include "render/prt/cube_light.h"
#include "render/reference/reference.h"
#include "render/technique/registry.h"
#include "scenes/error.h"
#include "tests/gpu/transfer_fixture.h"

namespace maquette {
namespace {

TEST_F(TransferMode, APlateUnderAConstantSkyShowsItsAlbedo) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  const glm::vec3 albedo(0.8f, 0.5f, 0.2f), sky(2.0f, 3.0f, 4.0f);
  auto scene = std::make_shared<Scene>();
  scene->materials.push_back(test::matte(albedo));
  test::add(scene.get(), test::make_grid({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 4, 0), "plate");
  renderer.set_scene(scene);
  renderer.set_environment(test::constant_sky(sky));
  FrameRequest request = look(small_request());
  request.settings.set("prt.rays", 8);
  const Drawn drawn = draw(&renderer, request);
  int covered = 0;
  for (int y = 0; y < request.height; ++y)
    for (int x = 0; x < request.width; ++x) {
      if (drawn.picture.at(x, y, 3) < 1.0f) continue;
      ++covered;
      // 8 x 8 points of each direction's texel integrate the cosine within 1 %.
      for (int c = 0; c < 3; ++c)
        EXPECT_NEAR(drawn.picture.at(x, y, c), albedo[c] * sky[c], 0.01f * albedo[c] * sky[c]);
    }
  EXPECT_GT(covered, 500);
  EXPECT_GT(drawn.stats.gpu_bytes.at("prt"), 0u);
  EXPECT_EQ(drawn.stats.technique.at("prt_vertices"), 25.0);
  EXPECT_TRUE(take_gl_errors().empty());
}

TEST_F(TransferMode, AgreesWithTheReferenceUnderASmoothSky) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  const auto scene = covered_plate();
  auto sky = std::make_shared<Environment>(*test::constant_sky(1.0f));
  for (int y = 0; y < sky->height; ++y)
    for (int x = 0; x < sky->width; ++x) {
      const glm::dvec3 d = direction_from_latlong(x + 0.5, y + 0.5, sky->width, sky->height);
      sky->rgb[static_cast<std::size_t>(y * sky->width + x)] = glm::vec3(1.0 + d.x, 1.0 + 0.8 * d.z, 1.2 + d.y);
    }
  renderer.set_scene(scene);
  renderer.set_environment(sky);
  FrameRequest request = look(small_request());
  request.settings.set("prt.vertices", 600);
  request.settings.set("prt.parts", std::string("plate"));
  request.settings.set("prt.coefficients", 1024);
  const Drawn drawn = draw(&renderer, request);
  const Image parts = renderer.read_debug_view("prt_vertices");
  ReferencePicture picture(
      build_path_scene({.scene = *scene, .environment = sky}),
      {.camera = request.camera, .width = request.width, .height = request.height, .paths = {.max_bounces = 1}});
  picture.add(100);
  Image reference = picture.mean();
  for (int y = 0; y < request.height; ++y)
    for (int x = 0; x < request.width; ++x)
      if (!(parts.at(x, y, 0) > 0.0f)) reference.at(x, y, 3) = 0.0f;
  EXPECT_LT(relative_difference(drawn.picture, reference), 0.06);
}

TEST_F(TransferMode, ComponentsAreChosenByTheErrorThatIsSaid) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  auto scene = std::make_shared<Scene>(*covered_plate());
  save_btf(path("small.exr"), *test::small_btf(4, 6));
  renderer.set_scene(scene);
  auto sky = std::make_shared<Environment>(*test::constant_sky(0.2f));
  for (int y = 0; y < sky->height / 3; ++y)
    for (int x = 0; x < sky->width / 4; ++x) sky->rgb[static_cast<std::size_t>(y * sky->width + x)] = glm::vec3(8.0f);
  renderer.set_environment(sky);
  FrameRequest request = look(small_request());
  request.settings.set("prt.parts", std::string("plate"));
  request.settings.set("prt.clusters", 81);  // of as many vertices: nothing is lost there
  request.settings.set("prt.coefficients", 1024);
  const auto draw_with = [&](int most, double error) {
    request.settings.set("prt.btf_components", most);
    request.settings.set("prt.btf_error", error);
    return draw(&renderer, request);
  };
  const Drawn all = draw_with(8, 0.0), one = draw_with(1, 0.0), chosen = draw_with(8, 2.0);
  const auto said = [](const Drawn& drawn) { return drawn.stats.technique.at("prt_error"); };
  const double missed = relative_difference(one.picture, all.picture);
  EXPECT_GT(missed, 0.005);
  // What is said is an RMS over views and lights; here is one view, and one sky.
  EXPECT_GT(said(one), 0.6 * missed);
  EXPECT_LT(said(one), 2.0 * missed);
  EXPECT_LT(said(chosen), 0.022);
  EXPECT_LT(relative_difference(chosen.picture, all.picture), 0.02);
  // Light that is left out is said too.
  request.settings.set("prt.coefficients", 2);
  const Drawn dim = draw(&renderer, request);
  EXPECT_GT(said(dim), said(chosen) + 0.01);
}

TEST_F(TransferMode, StandsBtfsOfOneViewAndOfTwo) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  const auto scene = covered_plate();
  const auto sky = test::constant_sky(1.0f);
  renderer.set_environment(sky);
  FrameRequest request = look(small_request());
  request.settings.set("prt.vertices", 600);
  request.settings.set("prt.parts", std::string("plate"));
  request.settings.set("prt.coefficients", 1024);
  for (const std::vector<glm::dvec3>& views :
       {std::vector{direction_of_angles(0.0, 0.0)}, std::vector{direction_of_angles(50.0, 20.0)},
        std::vector{direction_of_angles(10.0, 0.0), direction_of_angles(60.0, 100.0)}}) {
    save_btf(path("small.exr"), *test::small_btf(4, 2, views));
    renderer.set_scene(std::make_shared<Scene>(*scene));
    const Image picture = draw(&renderer, request).picture;
    const Image parts = renderer.read_debug_view("prt_vertices");
    ReferencePicture traced(
        build_path_scene({.scene = *scene, .environment = sky}),
        {.camera = request.camera, .width = request.width, .height = request.height, .paths = {.max_bounces = 1}});
    traced.add(100);
    Image reference = traced.mean();
    for (int y = 0; y < request.height; ++y)
      for (int x = 0; x < request.width; ++x)
        if (!(parts.at(x, y, 0) > 0.0f)) reference.at(x, y, 3) = 0.0f;
    EXPECT_LT(relative_difference(picture, reference), 0.06) << views.size();
  }
}

TEST_F(TransferMode, KeptLightIsShownOverTheSky) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  renderer.set_scene(covered_plate());
  const auto sky = test::sky_with_lamp({0.5f, 0.2f, -0.8f}, glm::vec3(60.0f));
  renderer.set_environment(sky);
  FrameRequest request = look(small_request());
  // Upwards: coefficients that light from below the plate alone would need bring nothing, and are not kept.
  request.camera.eye = {0.6f, 0.2f, 2.4f};
  request.camera.target = {0.0f, 1.9f, 0.0f};
  request.env_rotation_rad = 0.4f;
  request.env_scale = 3.0f;
  request.settings.set("prt.parts", std::string("plate"));
  const CubeDirections cube(4);
  const CubePyramid pyramid(*sky);
  double last = 10.0;  // of the upper sky alone, one coefficient a face may be worse than none
  for (const int coefficients : {1, 4, 1024}) {
    request.settings.set("prt.coefficients", coefficients);
    const Image picture = draw(&renderer, request).picture;
    const Image kept = renderer.read_debug_view("prt_kept");
    const CubeLight light = pyramid.resample(cube, environment_rotation(0.4));
    const CameraFrame frame = make_camera_frame(request.camera, request.width, request.height, {});
    double squares = 0.0, all = 0.0;
    for (int y = 0; y < request.height; ++y)
      for (int x = 0; x < request.width; ++x) {
        if (picture.at(x, y, 3) > 0.0f) continue;
        const glm::vec2 at((2.0f * static_cast<float>(x) + 1.0f) / static_cast<float>(request.width) - 1.0f,
                           1.0f - (2.0f * static_cast<float>(y) + 1.0f) / static_cast<float>(request.height));
        const CubePoint p = cube_point(glm::normalize(glm::dvec3(frame.ray_through(at).direction)));
        const int u = std::min(static_cast<int>(2.0 * (p.u + 1.0)), 3),
                  v = std::min(static_cast<int>(2.0 * (p.v + 1.0)), 3);
        const double expected = 3.0 * static_cast<double>(light((p.face * 4 + v) * 4 + u, 1));
        squares += std::pow(static_cast<double>(kept.at(x, y, 1)) - expected, 2.0);
        all += expected * expected;
      }
    ASSERT_GT(all, 0.0);
    const double error = std::sqrt(squares / all);
    EXPECT_LT(error, last) << coefficients;
    last = error;
  }
  EXPECT_LT(last, 1e-4);
}

TEST_F(TransferMode, HoldsItsBakeAndShowsWhatIsThere) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  renderer.set_scene(covered_plate());
  renderer.set_environment(test::constant_sky(1.0f));
  FrameRequest request = look(small_request());
  request.settings.set("prt.parts", std::string("plate"));
  request.settings.set("prt.run", std::string("hold"));
  EXPECT_FALSE(renderer.finish_background_work(request));
  renderer.render(request);
  EXPECT_TRUE(renderer.background_work().empty());
  request.settings.set("prt.run", std::string("auto"));
  const Image baked = draw(&renderer, request).picture;
  request.settings.set("prt.run", std::string("hold"));
  EXPECT_EQ(draw(&renderer, request).picture.data, baked.data);
}

TEST_F(TransferMode, SaysThatItsBakeIsStale) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  const auto scene = covered_plate();
  renderer.set_scene(scene);
  renderer.set_environment(test::constant_sky(1.0f));
  FrameRequest request = look(small_request());
  request.settings.set("prt.parts", std::string("plate"));
  const auto notes = [&](const FrameRequest& r) {
    std::string all;
    const FrameStats stats = draw(&renderer, r).stats;
    for (const std::string& note : stats.status.own_bakes.at("prt").notes) all += note + "; ";
    return all;
  };
  const std::atomic<bool> never{false};
  builtin_registry().find_bake("prt").run({*scene, -1, request.settings, {}, path("bakes")},
                                          {never, [](const std::string&, double) {}, [](const std::string&) {}});
  EXPECT_EQ(notes(request), "");
  // What casts shadows moves while bakes are held, and comes back.
  auto moved = std::make_shared<Scene>(*scene);
  moved->nodes[1].local = glm::translate(glm::mat4(1.0f), glm::vec3(0.3f, 0.0f, 0.2f)) * moved->nodes[1].local;
  FrameRequest held = request;
  held.settings.set("prt.run", std::string("hold"));
  ASSERT_TRUE(renderer.move_nodes(moved));
  EXPECT_NE(notes(held).find("changed since it was baked"), std::string::npos) << notes(held);
  EXPECT_EQ(notes(request), "") << "it is baked again";
  ASSERT_TRUE(renderer.move_nodes(scene));
  draw(&renderer, request);
  EXPECT_EQ(notes(held), "");
  // A bake in a folder.
  request.settings.set("prt.bake", path("bakes"));
  request.settings.set("prt.stale", std::string("show"));
  renderer.set_scene(moved);
  EXPECT_NE(notes(request).find("what casts shadows did not turn along"), std::string::npos) << notes(request);
  renderer.set_scene(scene);
  EXPECT_EQ(notes(request), "");
}

TEST_F(TransferMode, IsBakedBeforeThereIsAnEnvironment) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  renderer.set_scene(covered_plate());
  const FrameRequest request = look(small_request());
  EXPECT_TRUE(renderer.finish_background_work(request));
  EXPECT_THROW(renderer.render(request), Error);
  renderer.set_environment(test::constant_sky(1.0f));
  EXPECT_GT(draw(&renderer, request).picture.at(32, 24, 1), 0.0f);
}

TEST_F(TransferMode, ErrorOfVerticesFallsWithComponents) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  renderer.set_scene(covered_plate());
  renderer.set_environment(test::constant_sky(1.0f));
  FrameRequest request = look(small_request());
  request.settings.set("prt.parts", std::string("plate"));
  double last = 1.0;
  for (const int components : {0, 2, 6}) {
    request.settings.set("prt.components", components);
    const Drawn drawn = draw(&renderer, request);
    const Image errors = renderer.read_debug_view("prt_error");
    double sum = 0.0;
    int count = 0;
    for (int y = 0; y < request.height; ++y)
      for (int x = 0; x < request.width; ++x)
        if (errors.at(x, y, 3) > 0.0f) sum += static_cast<double>(errors.at(x, y, 0)), ++count;
    ASSERT_GT(count, 300);
    EXPECT_GT(sum, 0.0);
    EXPECT_LT(sum / count, 0.8 * last);
    last = sum / count;
  }
}

TEST_F(TransferMode, LightTurnsAsIfItWereGivenTurned) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  renderer.set_scene(covered_plate());
  const auto sky = test::sky_with_lamp({0.5f, 0.6f, 0.8f}, glm::vec3(60.0f));
  renderer.set_environment(sky);
  FrameRequest request = look(small_request());
  request.settings.set("prt.parts", std::string("plate"));
  const Image straight = draw(&renderer, request).picture;
  request.env_rotation_rad = glm::radians(37.0f);
  const Image turned = draw(&renderer, request).picture;
  // The map itself turned, in double, on four times as many texels.
  auto given = std::make_shared<Environment>();
  given->width = 4 * sky->width;
  given->height = 4 * sky->height;
  const double c = std::cos(glm::radians(37.0)), s = std::sin(glm::radians(37.0));
  for (int y = 0; y < given->height; ++y)
    for (int x = 0; x < given->width; ++x) {
      const glm::dvec3 d = direction_from_latlong(x + 0.5, y + 0.5, given->width, given->height);
      given->rgb.emplace_back(evaluate_environment(*sky, {c * d.x - s * d.z, d.y, s * d.x + c * d.z}));
    }
  request.env_rotation_rad = 0.0f;
  renderer.set_environment(given);
  const Image expected = draw(&renderer, request).picture;
  EXPECT_LT(relative_difference(turned, expected), 0.01);
  EXPECT_GT(relative_difference(straight, expected), 0.05);
  // Twice the light is twice the picture, and needs no new sums.
  request.env_scale = 2.0f;
  const Drawn bright = draw(&renderer, request);
  for (int y = 0; y < request.height; y += 5)
    for (int x = 0; x < request.width; x += 5)
      if (expected.at(x, y, 3) >= 1.0f) {
        EXPECT_NEAR(bright.picture.at(x, y, 1), 2.0f * expected.at(x, y, 1), 1e-4f * expected.at(x, y, 1));
      }
}

TEST_F(TransferMode, ATurnedObjectTakesTheLightInItsOwnFrame) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  const auto sky = test::sky_with_lamp({0.5f, 0.6f, 0.8f}, glm::vec3(60.0f));
  const auto scene = covered_plate();
  FrameRequest request = look(small_request());
  request.settings.set("prt.parts", std::string("plate"));
  const glm::mat4 turn(glm::rotate(glm::dmat4(1.0), glm::radians(25.0), glm::normalize(glm::dvec3(0.3, 0.8, -0.5))));
  auto turned = std::make_shared<Scene>(*scene);
  for (Node& node : turned->nodes) node.local = turn * node.local;
  FrameRequest along = request;
  along.camera.eye = glm::vec3(turn * glm::vec4(request.camera.eye, 1.0f));
  along.camera.target = glm::vec3(turn * glm::vec4(request.camera.target, 1.0f));
  along.camera.up = glm::mat3(turn) * request.camera.up;
  auto given = std::make_shared<Environment>();
  given->width = 4 * sky->width;
  given->height = 4 * sky->height;
  for (int y = 0; y < given->height; ++y)
    for (int x = 0; x < given->width; ++x)
      given->rgb.emplace_back(evaluate_environment(
          *sky, glm::dmat3(turn) * direction_from_latlong(x + 0.5, y + 0.5, given->width, given->height)));
  // Baked as it was; the turned scene is shown from the same files.
  const std::atomic<bool> never{false};
  builtin_registry().find_bake("prt").run({*scene, -1, request.settings, {}, path("bakes")},
                                          {never, [](const std::string&, double) {}, [](const std::string&) {}});
  request.settings.set("prt.bake", path("bakes"));
  along.settings = request.settings;
  renderer.set_scene(turned);
  renderer.set_environment(sky);
  const Image shown = draw(&renderer, along).picture;
  renderer.set_scene(scene);
  const Image straight = draw(&renderer, request).picture;
  renderer.set_environment(given);
  const Image expected = draw(&renderer, request).picture;
  EXPECT_LT(relative_difference(shown, expected), 0.01);
  EXPECT_GT(relative_difference(straight, expected), 0.05);
  EXPECT_TRUE(take_gl_errors().empty());
}

TEST_F(TransferMode, ShowsNoSeamsWhereTheNearestViewsChange) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  auto scene = covered_plate();
  scene->nodes[1].visible = false;
  save_btf(path("small.exr"), *test::small_btf(1, 2));
  renderer.set_scene(scene);
  renderer.set_environment(test::sky_with_lamp({0.5f, 0.6f, 0.8f}, glm::vec3(60.0f)));
  FrameRequest request = look(small_request());
  request.settings.set("prt.clusters", 1);
  request.settings.set("prt.parts", std::string("plate"));
  // One texel on a flat plate: light varies smoothly, and steps between neighbours show seams.
  for (const float x : {-1.5f, -0.4f, 0.0f, 0.7f, 1.6f}) {
    request.camera.eye.x = x;
    const Image picture = draw(&renderer, request).picture;
    double most = 0.0, mean = 0.0;
    int count = 0;
    for (int y = 1; y + 1 < request.height; ++y)
      for (int i = 1; i + 1 < request.width; ++i) {
        bool inside = true;
        for (int dy = -1; dy <= 1; ++dy)
          for (int dx = -1; dx <= 1; ++dx) inside = inside && picture.at(i + dx, y + dy, 3) >= 1.0f;
        if (!inside) continue;
        const double bend =
            static_cast<double>(picture.at(i - 1, y, 1) - 2.0f * picture.at(i, y, 1) + picture.at(i + 1, y, 1));
        most = std::max(most, std::abs(bend));
        mean += static_cast<double>(picture.at(i, y, 1));
        ++count;
      }
    ASSERT_GT(count, 300);
    EXPECT_LT(most, 0.03 * mean / count) << x;
  }
}

TEST_F(TransferMode, ViewsOfLightAreToneMapped) {
  int of_light = 0;
  for (const DebugViewInfo& view : builtin_registry().find_mode("prt").views) {
    if (view.help.find("cd/m2") == std::string::npos) continue;
    ++of_light;
    EXPECT_EQ(view.colors, ViewColors::radiance) << view.name;
  }
  EXPECT_EQ(of_light, 3);
}

TEST_F(TransferMode, StandsBesideOtherModesAndCostsNothingElsewhere) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  renderer.set_scene(covered_plate());
  renderer.set_environment(test::constant_sky(1.0f));
  FrameRequest request = look(small_request());
  request.mode = "splitsum";
  EXPECT_EQ(draw(&renderer, request).stats.gpu_bytes.count("prt"), 0u);
  request.part_modes = {{"plate", "prt"}};
  EXPECT_GT(draw(&renderer, request).stats.gpu_bytes.at("prt"), 0u);
  const Image inside = renderer.read_debug_view("prt_clusters");
  int points = 0;
  for (int y = 0; y < request.height; ++y)
    for (int x = 0; x < request.width; ++x) points += inside.at(x, y, 0) > 0.0f ? 1 : 0;
  EXPECT_GT(points, 50);
  EXPECT_LT(points, request.width * request.height * 3 / 4);
  for (const char* view : {"prt_vertices", "prt_light", "prt_component"}) renderer.read_debug_view(view);
  EXPECT_TRUE(take_gl_errors().empty());
}

TEST_F(TransferMode, MirroredRaysShowIt) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  renderer.set_scene(mirrored_plate());
  renderer.set_environment(test::constant_sky(1.0f));
  FrameRequest request = look(small_request());
  request.reflections = "raytraced";
  request.settings.set("prt.parts", std::string("plate"));
  const Drawn drawn = draw(&renderer, request);
  for (const float v : drawn.picture.data) ASSERT_TRUE(std::isfinite(v));
  request.reflections = "off";
  EXPECT_GT(relative_difference(draw(&renderer, request).picture, drawn.picture), 0.001);
  EXPECT_TRUE(take_gl_errors().empty());
}

TEST_F(TransferMode, ExtremeLightAndShadowStayFinite) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  // Inside a closed box nothing arrives: all transfer is black.
  renderer.set_scene(std::make_shared<Scene>(test::box_scene(6, 1, test::matte(glm::vec3(0.5f)))));
  auto hot = std::make_shared<Environment>(*test::constant_sky(0.0f));
  hot->rgb[100] = glm::vec3(1e7f);
  renderer.set_environment(hot);
  FrameRequest request = small_request();
  request.camera.eye = {0.2f, 0.1f, 0.3f};
  request.camera.target = {0.0f, 0.0f, -1.0f};
  const Drawn drawn = draw(&renderer, request);
  for (int y = 0; y < request.height; ++y)
    for (int x = 0; x < request.width; ++x)
      for (int c = 0; c < 3; ++c) EXPECT_EQ(drawn.picture.at(x, y, c), 0.0f);
  renderer.set_scene(covered_plate());
  request.settings.set("prt.parts", std::string("plate"));
  for (const float v : draw(&renderer, look(request)).picture.data) ASSERT_TRUE(std::isfinite(v));
  renderer.set_environment(test::constant_sky(0.0f));
  for (const float v : draw(&renderer, look(request)).picture.data) ASSERT_TRUE(std::isfinite(v));
  EXPECT_TRUE(take_gl_errors().empty());
}

}  // namespace
}  // namespace maquette
