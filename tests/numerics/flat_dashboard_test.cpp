// A flat Lambertian dashboard under a flat pane in an even sky: what the pane adds has a closed form, R(theta) rho L,
// at every pixel. Every reflector technique, the layers of the picture, and the path tracer are held against it.
#include <gtest/gtest.h>

#include <cmath>

#include "render/gl/context.h"
#include "render/inspection/pane_optics.h"
#include "render/reference/path_scene.h"
#include "render/renderer.h"
#include "scenes/error.h"
#include "scenes/luminance.h"
#include "tests/support/test_scenes.h"
#include "viewer/measure/measure_run.h"

namespace maquette {
namespace {

constexpr float kSky = 1000.0f, kDash = 0.13f, kIndex = 1.52f;
const glm::vec3 kLow(-0.8f, 0.05f, 1.2f), kAcross(1.6f, 0.0f, 0.0f), kUp(0.0f, 0.7f, -0.8f);

std::shared_ptr<const Scene> dashboard_scene() {
  auto scene = std::make_shared<Scene>();
  Material dash, glass;
  dash.name = "dash";
  dash.base_color = glm::vec4(glm::vec3(kDash), 1.0f);
  dash.metallic = 0.0f;
  dash.specular = 0.0f;
  dash.double_sided = true;
  glass.name = "glass";
  glass.transmission = 1.0f;
  glass.glass = true;
  glass.ior = kIndex;
  glass.metallic = glass.roughness = 0.0f;
  glass.double_sided = true;
  scene->materials = {dash, glass};
  test::add(scene.get(), test::make_grid({-3.0f, 0.0f, -2.0f}, {6, 0, 0}, {0, 0, 7.0f}, 24, 0), "dash");
  test::add(scene.get(), test::make_grid(kLow, kAcross, kUp, 8, 1), "windshield")->reflector = true;
  return scene;
}

std::shared_ptr<const Environment> even_sky() {
  auto sky = std::make_shared<Environment>();
  sky->name = "even";
  sky->width = 64;
  sky->height = 32;
  sky->rgb.assign(64 * 32, glm::vec3(kSky));
  sky->hash = 36;
  return sky;
}

FrameRequest request_of(const std::string& technique, const std::string& layer) {
  FrameRequest r;
  r.mode = "splitsum";
  r.width = 96;
  r.height = 64;
  r.reflections = technique;
  r.camera.eye = {0.1f, 0.9f, -0.5f};
  r.camera.target = {0.0f, 0.4f, 0.8f};
  r.camera.fov_y_rad = 0.5f;
  r.settings.set("reflections.resolution", std::string("full"));
  r.settings.set("reflections.layer", layer);
  r.settings.set("shading.visibility", std::string("none"));
  r.settings.set("shading.indirect", std::string("none"));
  return r;
}

/// Closed form of the reflected luminance of a pixel; below 0 outside the pane or within two pixels of its edge.
double expected(const FrameRequest& r, const EyeRays& rays, std::size_t pixel) {
  const glm::dvec3 from(rays.origins[pixel]), along(rays.directions[pixel]);
  const glm::dvec3 normal = glm::normalize(glm::cross(glm::dvec3(kAcross), glm::dvec3(kUp)));
  const double t = glm::dot(glm::dvec3(kLow) - from, normal) / glm::dot(along, normal);
  const glm::dvec3 at = from + t * along - glm::dvec3(kLow);
  const double u = at.x / static_cast<double>(kAcross.x), v = at.y / static_cast<double>(kUp.y);
  const double margin = 4.0 / r.height;
  if (u < margin || u > 1.0 - margin || v < margin || v > 1.0 - margin) return -1.0;
  const double theta = std::acos(std::abs(glm::dot(along, normal)));
  return static_cast<double>(kSky * kDash) * pane_optics(theta, static_cast<double>(kIndex), 1.0).reflected.mean();
}

class FlatDashboard : public testing::Test {
 protected:
  void SetUp() override {
    const FrameRequest r = request_of("off", "all");
    rays_ = eye_rays(r.camera, r.width, r.height, compute_bounds(*scene_));
    renderer_.set_scene(scene_);
    renderer_.set_environment(sky_);
  }
  Image draw(const FrameRequest& r) {
    EXPECT_TRUE(renderer_.finish_background_work(r));
    renderer_.render(r);
    return renderer_.read_radiance();
  }

  GlContext context_ = GlContext::create_headless();
  std::shared_ptr<const Scene> scene_ = dashboard_scene();
  std::shared_ptr<const Environment> sky_ = even_sky();
  EyeRays rays_;
  Renderer renderer_;
};

double luminance_of(const Image& image, std::size_t pixel) {
  const std::size_t at = pixel * static_cast<std::size_t>(image.channels);
  return luminance(glm::dvec3(image.data[at], image.data[at + 1], image.data[at + 2]));
}

TEST_F(FlatDashboard, EveryTechniqueReflectsTheClosedForm) {
  const std::vector<std::string> techniques = builtin_registry().names(TechniqueKind::reflector);
  EXPECT_GE(techniques.size(), 4u);
  for (const std::string& technique : techniques) {
    const FrameRequest r = request_of(technique, "reflected");
    const Image reflected = draw(r);
    std::size_t count = 0;
    double worst = 0.0;
    for (std::size_t i = 0; i < rays_.origins.size(); ++i) {
      const double want = expected(r, rays_, i);
      if (want < 0.0) continue;
      ++count;
      worst = std::max(worst, std::abs(luminance_of(reflected, i) / want - 1.0));
    }
    EXPECT_GT(count, 1000u) << technique;
    EXPECT_LT(worst, 0.01) << technique;
  }
}

TEST_F(FlatDashboard, ReflectedAndTransmittedSumToAll) {
  const Image all = draw(request_of("raytraced", "all")), reflected = draw(request_of("raytraced", "reflected")),
              transmitted = draw(request_of("raytraced", "transmitted"));
  double light = 0.0;
  for (std::size_t i = 0; i < rays_.origins.size(); ++i) {
    const double sum = luminance_of(reflected, i) + luminance_of(transmitted, i);
    ASSERT_NEAR(sum, luminance_of(all, i), 1e-4 * sum) << i;
    light += luminance_of(reflected, i);
    EXPECT_EQ(reflected.data[4 * i + 3], all.data[4 * i + 3]) << "alpha stays";
  }
  EXPECT_GT(light, 0.0);
}

/// The front face's image and the second one make all that a pane reflects, wherever both show the dashboard.
TEST_F(FlatDashboard, TheGhostIsTheRestOfTheReflection) {
  FrameRequest ghost = request_of("raytraced", "ghost"), both = request_of("raytraced", "reflected");
  ghost.settings.set("reflections.ghost", true);
  both.settings.set("reflections.ghost", true);
  const Image second = draw(ghost), sum = draw(both);
  const glm::dvec3 normal = glm::normalize(glm::cross(glm::dvec3(kAcross), glm::dvec3(kUp)));
  for (std::size_t i = 0; i < rays_.origins.size(); ++i) {
    if (expected(both, rays_, i) < 0.0) continue;
    const double theta = std::acos(std::abs(glm::dot(glm::dvec3(rays_.directions[i]), normal)));
    const PaneOptics o = pane_optics(theta, static_cast<double>(kIndex), 1.0);
    const double level = static_cast<double>(kSky * kDash);
    ASSERT_NEAR(luminance_of(sum, i), level * o.reflected.mean(), 0.01 * level * o.reflected.mean()) << i;
    ASSERT_NEAR(luminance_of(second, i), level * (o.reflected.mean() - o.surface.mean()),
                0.01 * level * o.surface.mean())
        << i;
  }
}

/// Without shadows, as the closed form; and the geometry of the probe.
TEST_F(FlatDashboard, PathsAndProbesAgreeWithTheClosedForm) {
  const FrameRequest r = request_of("off", "all");
  const std::shared_ptr<const PathScene> paths = build_path_scene({.scene = *scene_, .environment = sky_});
  const std::vector<Sight> sights = look_at_all(*paths, rays_, {0.0, 1.0, 0.0});
  std::vector<std::size_t> pixels;
  for (std::size_t i = 0; i < rays_.origins.size(); ++i)
    if (expected(r, rays_, i) >= 0.0) pixels.push_back(i);
  PathOptions direct;
  direct.transport = Transport::direct;
  const LayerPictures traced = trace_layers(*paths, direct, rays_, pixels, {r.width, r.height}, 16, 1);
  double sum = 0.0, want = 0.0;
  for (const std::size_t i : pixels) {
    sum += luminance_of(traced.reflected, i);
    want += expected(r, rays_, i);
    ASSERT_TRUE(sights[i].pane);
    EXPECT_NEAR(static_cast<double>(kSky * kDash) * sights[i].pane->optics.reflected.mean(), expected(r, rays_, i),
                1e-3 * expected(r, rays_, i));
    EXPECT_EQ(scene_->nodes[static_cast<std::size_t>(sights[i].pane->mirrored.node)].name, "dash");
    const Met& met = sights[i].pane->mirrored;
    EXPECT_NEAR(met.position.y, 0.0, 1e-5);
    EXPECT_NEAR(glm::distance(met.position, sights[i].pane->position), met.distance_m, 1e-4);
  }
  EXPECT_NEAR(sum, want, 0.01 * want);
}

/// The pane's plane is upright in the driver's view: what is s-polarised swings sideways, and sunglasses remove it.
TEST_F(FlatDashboard, SunglassesRemoveWhatIsPolarisedSideways) {
  const std::shared_ptr<const PathScene> paths = build_path_scene({.scene = *scene_, .environment = sky_});
  const glm::vec3 eye(0.0f, 0.9f, -0.5f), middle = kLow + 0.5f * kAcross + 0.5f * kUp;
  const Sight sight = look_along(*paths, {eye, glm::normalize(middle - eye)}, {0.0, 1.0, 0.0});
  ASSERT_TRUE(sight.pane);
  EXPECT_NEAR(sight.pane->s_through_sunglasses, 0.0, 1e-9);
  const Polarised& r = sight.pane->optics.reflected;
  EXPECT_NEAR(polarisation_factor(sight.pane, Polarisation::sunglasses, true), 0.5 * r.p / r.mean(), 1e-9);
  EXPECT_NEAR(polarisation_factor(sight.pane, Polarisation::s, true), r.s / r.mean(), 1e-12);
  EXPECT_NEAR(
      polarisation_factor(sight.pane, Polarisation::s, true) + polarisation_factor(sight.pane, Polarisation::p, true),
      2.0, 1e-12);
  EXPECT_EQ(polarisation_factor(std::nullopt, Polarisation::sunglasses, false), 0.5);
}

SceneOptions measured_view(const std::string& mode) {
  SceneOptions options;
  options.mode = mode;
  options.width = 48;
  options.height = 32;
  options.samples = mode == "reference" ? 64 : 0;
  options.eye = {0.1f, 0.9f, -0.5f};
  options.target = {0.0f, 0.4f, 0.8f};
  options.fov_deg = 28.0f;
  options.settings.set("shading.visibility", std::string("none"));
  options.settings.set("shading.indirect", std::string("none"));
  return options;
}

/// All paths find that the pane dims what lights the dashboard; direct ones have the closed form, and so do the modes
/// that compute no more.
TEST(MeasureDashboard, TheTransportIsTheOneThatIsAsked) {
  const auto share = [](const SceneOptions& options) {
    const RegionValues region = measure(options, {}, dashboard_scene(), even_sky()).eyes[0].regions[0];
    return region.reflected.mean / (static_cast<double>(kSky * kDash) * region.reflectance.mean);
  };
  SceneOptions paths = measured_view("reference");
  EXPECT_LT(share(paths), 0.98);
  paths.settings.set("reference.transport", std::string("direct"));
  EXPECT_NEAR(share(paths), 1.0, 0.01);
  EXPECT_NEAR(share(measured_view("splitsum")), 1.0, 0.01);
}

/// A section plane takes from the figures what it takes from the picture, on either side of the eye.
TEST(MeasureDashboard, ASectionPlaneCutsWhatIsMeasured) {
  const auto region = [](SceneOptions options, std::optional<glm::vec4> section) {
    options.settings.set("reference.transport", std::string("direct"));
    options.section = section;
    return measure(options, {}, dashboard_scene(), even_sky()).eyes[0].regions[0];
  };
  const RegionValues whole = region(measured_view("reference"), std::nullopt);
  struct Case {
    glm::vec4 section{};
    bool cuts_pane, opens_sky;
  };
  for (const Case& c : {Case{{1, 0, 0, 0.1f}, true, false}, Case{{0, 0, -1, -0.7f}, true, false},
                        Case{{0, 0, 1, 0.8f}, true, true}, Case{{0, 0, 1, 2.5f}, false, true}}) {
    const RegionValues traced = region(measured_view("reference"), c.section),
                       drawn = region(measured_view("splitsum"), c.section);
    EXPECT_EQ(traced.pane_pixels, drawn.pane_pixels);
    if (c.cuts_pane)
      EXPECT_LT(traced.pane_pixels, 9 * whole.pane_pixels / 10) << c.section.x << c.section.z;
    else
      EXPECT_EQ(traced.pane_pixels, whole.pane_pixels);
    EXPECT_EQ(traced.transmitted.mean > 3.0 * whole.transmitted.mean, c.opens_sky) << traced.transmitted.mean;
    EXPECT_GT(drawn.reflected.min, 0.0) << "each pixel of the region shows the pane";
    EXPECT_NEAR(drawn.reflected.mean, traced.reflected.mean, 0.01 * traced.reflected.mean);
    EXPECT_NEAR(drawn.transmitted.mean, traced.transmitted.mean, 0.01 * traced.transmitted.mean);
  }
}

/// Bright stripes, which the first and the second image show at different places.
std::shared_ptr<const Scene> striped_dashboard() {
  auto scene = std::make_shared<Scene>(*dashboard_scene());
  scene->materials.push_back(scene->materials[0]);
  scene->materials[2].base_color = glm::vec4(glm::vec3(0.8f), 1.0f);
  for (int k = 0; k < 12; ++k)
    test::add(scene.get(),
              test::make_grid({-3.0f, 0.001f, -0.2f + 0.16f * static_cast<float>(k)}, {6, 0, 0}, {0, 0, 0.08f}, 4, 2),
              "stripe");
  return scene;
}

/// The layers that are kept have the second image, whether it is part of the picture or not, and whether frames or
/// paths draw it; both find it where the glass puts it.
TEST(MeasureDashboard, TheGhostIsAmongTheLayers) {
  const auto drawn = [](const std::string& mode, double thickness_mm) {
    SceneOptions options = measured_view(mode);
    options.settings.set("reference.transport", std::string("direct"));
    options.settings.set("reflections.thickness", thickness_mm);
    options.settings.set("reflections.resolution", std::string("full"));
    if (options.samples > 0) options.samples = 512;
    MeasureOptions kept;
    kept.layers = "kept.exr";
    LastEye last;
    measure(options, kept, striped_dashboard(), even_sky(), {}, &last);
    return last;
  };
  const LastEye frames = drawn("splitsum", 50.0), paths = drawn("reference", 50.0), thin = drawn("reference", 0.01);
  ASSERT_TRUE(frames.pictures.ghost && paths.pictures.ghost && thin.pictures.ghost);
  double apart = 0.0, moved = 0.0, light = 0.0;
  for (std::size_t i = 0; i < frames.sights.size(); ++i) {
    if (!frames.sights[i].pane) continue;
    const double of_paths = luminance_of(*paths.pictures.ghost, i);
    apart += std::abs(luminance_of(*frames.pictures.ghost, i) - of_paths);
    moved += std::abs(luminance_of(*thin.pictures.ghost, i) - of_paths);
    light += of_paths;
    const PaneOptics& o = frames.sights[i].pane->optics;
    const double first = luminance_of(thin.pictures.reflected, i) / o.reflected.mean();
    EXPECT_NEAR(luminance_of(*thin.pictures.ghost, i), first * (o.reflected.mean() - o.surface.mean()), 0.1 * first)
        << i;
  }
  EXPECT_GT(light, 0.0);
  EXPECT_GT(moved, 0.3 * light) << "the second image is beside the first one";
  EXPECT_LT(apart, 0.3 * moved) << "where frames have it, whose edges are smoothed";
}

/// The whole measurement, without a graphics context: a pane over a dashboard that the sky lights through it.
TEST(MeasureDashboard, ScalesWithLightAndReflectance) {
  SceneOptions options;
  options.mode = "reference";
  options.width = 48;
  options.height = 32;
  options.samples = 8;
  options.eye = {0.1f, 0.9f, -0.5f};
  options.target = {0.0f, 0.4f, 0.8f};
  options.fov_deg = 28.0f;
  MeasureOptions m;
  m.lux_on_glass = 88900.0;
  m.sweeps = {{"dash-reflectance", {0.13, 0.34}}};
  m.paths = 8;
  const Measurement result = measure(options, m, dashboard_scene(), even_sky());
  ASSERT_EQ(result.eyes.size(), 2u);
  const RegionValues &dark = result.eyes[0].regions[0], &light = result.eyes[1].regions[0];
  EXPECT_NEAR(result.eyes[0].light->illuminance_lx, 88900.0, 1.0);
  EXPECT_NEAR(light.reflected.mean / dark.reflected.mean, 0.34 / 0.13, 0.15 * 0.34 / 0.13);
  EXPECT_EQ(result.worst, 1u);
  ASSERT_TRUE(dark.traced && dark.flat_estimate_cdm2);
  EXPECT_NEAR(dark.traced->reflected.mean, dark.reflected.mean,
              3.0 * dark.traced->reflected.half_width + 0.05 * dark.reflected.mean);
  EXPECT_EQ(dark.mirrored.front().first, "dash");
  EXPECT_FALSE(result.not_modelled.empty());
  m.regions = {{"far", 40, 20, 20, 20}};
  EXPECT_THROW(measure(options, m, dashboard_scene(), even_sky()), UsageError) << "outside the picture";
  m.regions.clear();
  m.eye = EyePlace{};
  try {
    measure(options, m, dashboard_scene(), even_sky());
    ADD_FAILURE() << "there is no R-point";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("--r-point"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace maquette
