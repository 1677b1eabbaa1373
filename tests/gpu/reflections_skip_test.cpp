// Mirrored rays that nobody sees, and second images of panes.
#include "tests/gpu/reflections_fixture.h"

namespace maquette {
namespace {

using namespace test;

class ReflectionRays : public Reflections {};

/// A pane in front of a bright sky that mirrors a dim room with a lamp of the size of a hand.
Scene pane_before_the_sky(float lamp_cdm2) {
  Scene scene;
  scene.materials = {plain("grey", glm::vec3(0.3f)), plain("red", {0.8f, 0.1f, 0.05f}), plain("lamp", glm::vec3(0.0f)),
                     plain("glass", {0.95f, 0.97f, 0.96f})};
  scene.materials[2].emissive = glm::vec3(lamp_cdm2);
  scene.materials[3].glass = true;
  scene.materials[3].transmission = 1.0f;
  scene.materials[3].ior = 1.52f;
  add_box(&scene, {-4.0f, -3.0f, 2.2f}, {4.0f, 5.0f, 2.4f}, 0);
  add_box(&scene, {0.4f, 0.3f, 1.4f}, {0.8f, 0.9f, 1.7f}, 1);
  add(&scene, make_grid({-0.65f, 0.55f, 1.6f}, {0, 0.1f, 0}, {0.1f, 0, 0}, 2, 2), "lamp");
  add(&scene, make_grid({-1.0f, 0.0f, -1.0f}, {2, 0, 0}, {0, 1.2f, 0}, 24, 3), "pane")->reflector = true;
  return scene;
}

FrameRequest pane_request(const std::string& technique, bool display) {
  FrameRequest r = request_of(technique);
  r.camera.eye = {0.1f, 0.5f, 1.2f};
  r.camera.target = {0.0f, 0.6f, -1.0f};
  r.camera.fov_y_rad = 0.45f;
  r.display = display;
  return r;
}

/// Mean HDR-FLIP of all pixels, those of the sky too.
double flip_with_sky(Image image, Image reference) {
  for (std::size_t i = 3; i < image.data.size(); i += 4) image.data[i] = reference.data[i] = 1.0f;
  return measure_error(image, reference).figures.flip.value();
}

/// In front of a bright sky many mirrored rays are skipped without a visible difference; rays to bright parts are
/// traced.
TEST_F(ReflectionRays, RaysWithoutVisibleEffectAreSkipped) {
  double share[2] = {};
  for (const float lamp : {0.0f, 2e5f}) {
    SCOPED_TRACE(lamp);
    renderer_.set_scene(std::make_shared<Scene>(pane_before_the_sky(lamp)));
    const auto picture_of = [&](bool display) {
      FrameRequest request = pane_request("octree", display);
      EXPECT_TRUE(renderer_.finish_background_work(request));
      const FrameStats stats = renderer_.render(request);
      EXPECT_EQ(stats.technique.count("rays_skipped"), display ? 1u : 0u);
      if (display) share[lamp > 0.0f ? 1 : 0] = stats.technique.at("rays_skipped_share");
      return renderer_.read_radiance();
    };
    const Image all = picture_of(false), some = picture_of(true);
    const Image skipped = renderer_.read_debug_view("rays_skipped");
    double most = 0.0, count = 0.0;
    for (std::size_t i = 0; i < all.data.size(); i += 4) {
      most = std::max(most, static_cast<double>(std::abs(some.data[i + 1] - all.data[i + 1]) / all.data[i + 1]));
      count += static_cast<double>(skipped.data[i]);
    }
    EXPECT_GT(count, 1000.0);
    EXPECT_LT(most, 0.05);
    EXPECT_LT(flip_with_sky(some, all), 0.02);
    const auto errors = take_gl_errors();
    EXPECT_TRUE(errors.empty()) << errors.front();
  }
  EXPECT_GT(share[0], 0.2);
  EXPECT_LT(share[1], share[0] - 0.03) << "what mirrors the lamp is to be followed";
}

/// If the test for skipping would cost more than it saves, and in pictures for measurements, every ray is traced, and
/// the plan says why.
TEST_F(ReflectionRays, ThePlanSaysWhyNoRayIsSkipped) {
  renderer_.set_scene(std::make_shared<Scene>(pane_before_the_sky(0.0f)));
  for (const char* technique : {"raytraced", "bezier", "triangle", "octree"}) {
    const FrameRequest request = pane_request(technique, std::string(technique) != "octree");
    EXPECT_TRUE(renderer_.finish_background_work(request));
    const FrameStats stats = renderer_.render(request);
    EXPECT_EQ(stats.technique.count("rays_skipped"), 0u);
    EXPECT_EQ(std::count_if(stats.plan.left_out.begin(), stats.plan.left_out.end(),
                            [](const LeftOut& left) { return left.what == "skip"; }),
              1)
        << technique;
  }
}

/// A lamp as a thin upright bar, mirrored at about 60 degrees in a flat pane 5 mm thick: the distance of its two images
/// follows from the paths unfolded by Snell's law, height (tan theta) + 2 t tan(theta') each.
TEST_F(ReflectionRays, APaneShowsALampTwice) {
  constexpr double kWay = 2.0, kHeights = 1.2, kThickness = 0.005, kIndex = 1.52;
  Scene scene;
  scene.materials.assign(4, plain("dark", glm::vec3(0.0f)));
  scene.materials[2].emissive = glm::vec3(1e6f);
  scene.materials[3] = plain("clear", glm::vec3(1.0f));
  scene.materials[3].glass = true;
  scene.materials[3].transmission = 1.0f;
  scene.materials[3].ior = static_cast<float>(kIndex);
  add(&scene, make_grid({0.9995f, 0.3f, 0.6f}, {0.001f, 0, 0}, {0, 0.4f, 0}, 1, 2), "lamp");
  add(&scene, make_grid({-0.4f, 0.3f, 0.0f}, {0.8f, 0, 0}, {0, 0.4f, 0}, 8, 3), "pane")->reflector = true;
  renderer_.set_scene(std::make_shared<Scene>(scene));
  FrameRequest request = request_of("raytraced");
  request.camera.eye = {-1.0f, 0.5f, 0.6f};
  request.camera.target = {0.0f, 0.5f, 0.0f};
  request.camera.fov_y_rad = 0.012f;
  request.settings.set_from_text("reflections.ghost", "true");
  renderer_.render(request);
  const Image image = renderer_.read_radiance();
  std::vector<std::pair<double, double>> bars;  // weight, weighted column
  bool inside = false;
  for (int x = 0; x < image.width; ++x) {
    const auto v = static_cast<double>(image.at(x, image.height / 2, 1));
    const bool bright = v > 3e4;
    if (bright && !inside) bars.emplace_back(0.0, 0.0);
    inside = bright;
    if (!bright) continue;
    bars.back().first += v;
    bars.back().second += v * (x + 0.5);
  }
  ASSERT_EQ(bars.size(), 2u);
  double elevation[2];
  for (int k = 0; k < 2; ++k) {
    double low = 0.0, high = 1.5;
    for (int step = 0; step < 60; ++step) {
      const double theta = 0.5 * (low + high), s = std::sin(theta);
      const double way =
          kHeights * std::tan(theta) + (k == 0 ? 0.0 : 2.0 * kThickness * s / std::sqrt(kIndex * kIndex - s * s));
      (way < kWay ? low : high) = theta;
    }
    elevation[k] = low;
  }
  const double axis = std::atan(1.0 / 0.6), focal_px = 0.5 * image.height / std::tan(0.5 * 0.012);
  const double expected_px = focal_px * (std::tan(elevation[0] - axis) - std::tan(elevation[1] - axis));
  const double measured_px = std::abs(bars[1].second / bars[1].first - bars[0].second / bars[0].first);
  EXPECT_GT(expected_px, 10.0);
  EXPECT_NEAR(measured_px, expected_px, 0.35);
}

Material clear_glass() {
  Material m = plain("clear", glm::vec3(1.0f));
  m.glass = true;
  m.transmission = 1.0f;
  m.ior = 1.52f;
  return m;
}

/// The second image of thick, wedged panes agrees with rays: panes curved both ways, flat, and a mesh. It is several
/// pixels from the first, so a technique that confuses both fails.
TEST_F(ReflectionRays, SecondImagesAreWhereRaysShowThem) {
  const auto second_image = [&](const FrameRequest& request) {
    draw_reflection(&renderer_, request);
    return renderer_.read_debug_view("ghost");
  };
  const auto check = [&](const std::string& technique) {
    SCOPED_TRACE(technique);
    FrameRequest request = request_of(technique);
    request.settings.set_from_text("reflections.ghost", "true");
    request.settings.set_from_text("reflections.thickness", "20");
    request.settings.set_from_text("reflections.wedge", "10");
    FrameRequest exact = request;
    exact.reflections = "raytraced";
    const Image reference = second_image(exact), image = second_image(request);
    const Image first = renderer_.read_debug_view("reflection");
    const Difference d = compare(image, reference), between = compare(first, reference);
    EXPECT_LT(d.mean, 0.002);
    EXPECT_LT(d.share, 0.004);
    EXPECT_GT(between.share, 0.03);
  };
  for (const float bend : {0.15f, -0.15f, 0.0f}) {
    SCOPED_TRACE(bend);
    Scene scene = room();
    scene.materials[3] = clear_glass();
    add_patch(&scene, bend);
    scene.patches[0].reflector = true;
    renderer_.set_scene(std::make_shared<Scene>(scene));
    check("bezier");
    check("triangle");
  }
  Scene scene = room();
  scene.materials[3] = clear_glass();
  add_mesh_mirror(&scene, 0.15f, 6);
  renderer_.set_scene(std::make_shared<Scene>(scene));
  check("triangle");
}

}  // namespace
}  // namespace maquette
