// Shadows by rays from every point (render/shadow_rays): edges where the geometry puts them, panes that dim, and at
// rest the path tracer's direct light.
#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "render/gl/context.h"
#include "render/renderer.h"
#include "scenes/angles.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

constexpr int kShadowSide = 96;
/// Texels around the horizon of the skies below, and of one with a narrow sun.
constexpr int kSkyWidth = 128, kFineSkyWidth = 1024;

/// The texel of the sun.
glm::ivec2 sun_texel(int sky_width) { return {sky_width * 5 / 16, sky_width / 16}; }

glm::dvec3 to_sun(int sky_width = kSkyWidth) {
  const glm::dvec2 texel = glm::dvec2(sun_texel(sky_width)) + 0.5;
  const double lon = std::numbers::pi - 2.0 * std::numbers::pi * texel.x / sky_width,
               lat = std::numbers::pi / 2.0 - 2.0 * std::numbers::pi * texel.y / sky_width;
  return {std::cos(lat) * std::sin(lon), std::sin(lat), std::cos(lat) * std::cos(lon)};
}

/// A dim sky with a sun of one texel, as bright whatever its size.
std::shared_ptr<Environment> sunny(float sky, int sky_width = kSkyWidth) {
  auto environment = std::make_shared<Environment>();
  environment->name = "sunny";
  environment->width = sky_width;
  environment->height = sky_width / 2;
  environment->rgb.assign(static_cast<std::size_t>(sky_width) * static_cast<std::size_t>(sky_width / 2),
                          glm::vec3(sky));
  const glm::ivec2 texel = sun_texel(sky_width);
  const float smaller = static_cast<float>(sky_width) / kSkyWidth;
  environment->rgb[static_cast<std::size_t>(texel.y * sky_width + texel.x)] = glm::vec3(5000.0f * smaller * smaller);
  return environment;
}

class ShadowRays : public ::testing::Test {
 protected:
  /// A floor of two large triangles below a square of 1 m at 1 m.
  static Scene floor_below(const Material& square) {
    Scene scene;
    scene.materials = {test::matte(glm::vec3(0.5f)), square};
    scene.materials[0].double_sided = scene.materials[1].double_sided = true;
    test::add(&scene, test::make_grid({-20, 0, 20}, {40, 0, 0}, {0, 0, -40}, 1, 0));
    test::add(&scene, test::make_grid({-0.5f, 1, 0.5f}, {1, 0, 0}, {0, 0, -1}, 1, 1));
    return scene;
  }
  /// From below the square, straight down on its shadow.
  static FrameRequest request(const std::string& mode, const glm::dvec3& sun = to_sun()) {
    FrameRequest r;
    r.mode = mode;
    r.width = r.height = kShadowSide;
    r.samples = 64;
    const glm::dvec3 middle = -sun / sun.y;
    r.camera.target = glm::vec3(middle.x, 0.0, middle.z);
    r.camera.eye = r.camera.target + glm::vec3(0.0f, 0.95f, 0.0f);
    r.camera.up = {0, 0, -1};
    r.camera.fov_y_rad = 1.6f;
    r.settings.set("shading.indirect", std::string("none"));
    return r;
  }
  Image draw(const FrameRequest& r, int frames = 1) {
    renderer_.finish_background_work(r);
    for (int k = 0; k < frames; ++k) renderer_.render(r, frames > 1);
    const auto errors = take_gl_errors();
    EXPECT_TRUE(errors.empty()) << errors.front();
    return renderer_.read_radiance();
  }

  GlContext context_ = GlContext::create_headless();
  Renderer renderer_;
};

/// Where a pixel's centre sees the floor, and how far that is from the border of the square's shadow, in pixels; below
/// 0 inside.
double beyond_shadow_px(const FrameRequest& r, int x, int y) {
  const double pixel_m = 2.0 * std::tan(0.5 * static_cast<double>(r.camera.fov_y_rad)) * 0.95 / kShadowSide;
  const double px = (x + 0.5 - 0.5 * kShadowSide) * pixel_m, pz = (y + 0.5 - 0.5 * kShadowSide) * pixel_m;
  return (std::max(std::abs(px), std::abs(pz)) - 0.5) / pixel_m;
}

/// Checks that what lies more than a pixel beyond the penumbra of the square's shadow is lit, and what lies as far
/// within is dark.
void expect_shadow_of_square(const Image& image, const FrameRequest& r, double penumbra_px, const std::string& what) {
  double lit = 0.0, dark = 0.0, lit_count = 0.0, dark_count = 0.0;
  for (int y = 0; y < kShadowSide; ++y)
    for (int x = 0; x < kShadowSide; ++x) {
      const double off = beyond_shadow_px(r, x, y), value = static_cast<double>(image.at(x, y, 1));
      if (off > penumbra_px + 1.0) lit += value, ++lit_count;
      if (off < -penumbra_px - 1.0) dark += value, ++dark_count;
    }
  lit /= lit_count;
  dark /= dark_count;
  EXPECT_LT(dark, 0.1 * lit) << what;
  for (int y = 0; y < kShadowSide; ++y)
    for (int x = 0; x < kShadowSide; ++x) {
      const double off = beyond_shadow_px(r, x, y), value = static_cast<double>(image.at(x, y, 1));
      if (std::abs(off) <= penumbra_px + 1.0) continue;
      EXPECT_NEAR(value, off > 0.0 ? lit : dark, (off > 0.0 ? 0.15 : 0.1) * lit) << what << " " << x << ", " << y;
    }
}

TEST_F(ShadowRays, TheSunsEdgeIsWhereTheGeometryPutsIt) {
  renderer_.set_scene(std::make_shared<Scene>(floor_below(test::matte(glm::vec3(0.1f)))));
  // Suns of a texel, bilinear: as far as a texel from the middle each way. The fine one's penumbra is a third of a
  // pixel.
  for (const int sky_width : {kSkyWidth, kFineSkyWidth}) {
    renderer_.set_environment(sunny(0.05f, sky_width));
    const double texel_rad = 2.0 * std::numbers::pi / sky_width;
    const double penumbra_px = 1.2 * texel_rad * 1.2 / (2.0 * std::tan(0.8) * 0.95 / kShadowSide);
    for (const char* mode : {"uniform", "bandwidth"}) {
      const FrameRequest r = request(mode, to_sun(sky_width));
      expect_shadow_of_square(draw(r), r, penumbra_px, mode + std::string(", sky of ") + std::to_string(sky_width));
    }
  }
}

/// The square's shadow goes where it goes: the part that holds it moves, and a dent moves its surface.
TEST_F(ShadowRays, FollowMovedPartsAndDents) {
  const Scene scene = floor_below(test::matte(glm::vec3(0.1f)));
  renderer_.set_environment(sunny(0.05f, kFineSkyWidth));
  constexpr double kPenumbra_px = 0.5;
  for (const char* mode : {"uniform", "bandwidth"}) {
    renderer_.set_scene(std::make_shared<Scene>(scene));
    FrameRequest r = request(mode, to_sun(kFineSkyWidth));
    expect_shadow_of_square(draw(r), r, kPenumbra_px, mode);

    const glm::vec3 way(0.7f, 0.0f, -0.4f);
    auto moved = std::make_shared<Scene>(scene);
    moved->nodes.back().local[3] += glm::vec4(way, 0.0f);
    ASSERT_TRUE(renderer_.move_nodes(moved));
    r.camera.target += way;
    r.camera.eye += way;
    expect_shadow_of_square(draw(r), r, kPenumbra_px, mode + std::string(", moved"));

    ASSERT_TRUE(renderer_.move_nodes(std::make_shared<Scene>(scene)));
    r.camera.target -= 2.0f * way;
    r.camera.eye -= 2.0f * way;
    Primitive square = scene.meshes.back().primitives[0];
    for (glm::vec3& position : square.positions) position -= way;
    renderer_.update_mesh(static_cast<int>(scene.meshes.size()) - 1, square.positions, square.normals);
    expect_shadow_of_square(draw(r), r, kPenumbra_px, mode + std::string(", dented"));
  }
}

/// All of the direct light, lamps and the dim sky included, at rest: as the path tracer has it without bounces.
TEST_F(ShadowRays, AtRestTheDirectLightIsThePathTracers) {
  Material pane = test::clear_pane();
  pane.base_color = {0.3f, 0.8f, 0.6f, 1.0f};
  Material half = test::matte(glm::vec3(0.2f));
  half.alpha_mode = AlphaMode::blend;
  half.base_color.a = 0.5f;
  Material cut = test::matte(glm::vec3(0.2f));
  cut.alpha_mode = AlphaMode::mask;
  cut.alpha_cutoff = 0.5f;
  cut.base_color.a = 0.4f;
  for (const Material& square : {test::matte(glm::vec3(0.1f)), pane, half, cut}) {
    Scene scene = floor_below(square);
    PunctualLight lamp;
    lamp.kind = PunctualLight::Kind::point;
    lamp.intensity = 3.0f;
    scene.lights = {lamp};
    Node node;
    node.local = glm::mat4(1.0f);
    node.local[3] = {0.7f, 2.0f, 0.2f, 1.0f};
    node.light = 0;
    scene.roots.push_back(static_cast<int>(scene.nodes.size()));
    scene.nodes.push_back(node);
    renderer_.set_scene(std::make_shared<Scene>(scene));
    renderer_.set_environment(sunny(1.0f));
    FrameRequest reference = request("reference");
    reference.samples = 256;
    reference.settings.set("reference.bounces", 1);
    const Image expected = draw(reference);
    for (const char* mode : {"uniform", "bandwidth"}) {
      const Image image = draw(request(mode), 48);
      double worst = 0.0, mean = 0.0;
      constexpr int kBlock = 12;
      for (const float v : expected.data) mean += static_cast<double>(v) / static_cast<double>(expected.data.size());
      for (int by = 0; by < kShadowSide; by += kBlock)
        for (int bx = 0; bx < kShadowSide; bx += kBlock) {
          double a = 0.0, b = 0.0;
          for (int y = by; y < by + kBlock; ++y)
            for (int x = bx; x < bx + kBlock; ++x) {
              a += static_cast<double>(image.at(x, y, 1));
              b += static_cast<double>(expected.at(x, y, 1));
            }
          worst = std::max(worst, std::abs(a - b) / (b + 0.2 * mean * kBlock * kBlock));
        }
      EXPECT_LT(worst, 0.06) << mode << ", alpha " << square.base_color.a << (square.glass ? " glass" : "");
    }
  }
}

/// Surfaces that stay where they are get their sun by tiles that it reaches (SunShadows): as all points do elsewhere.
TEST_F(ShadowRays, WhileTheLightTurnsTheSunIsThatOfPicturesDrawnAnew) {
  Scene scene = floor_below(test::matte(glm::vec3(0.6f)));
  Material gloss = test::matte(glm::vec3(0.9f, 0.6f, 0.3f));
  gloss.metallic = 1.0f;
  gloss.roughness = 0.3f;
  scene.materials.push_back(gloss);
  test::add(&scene, test::make_grid({-0.9f, 0.1f, 0.3f}, {0.4f, 0.3f, 0}, {0, 0, -0.5f}, 3, 2));
  renderer_.set_scene(std::make_shared<Scene>(scene));
  renderer_.set_environment(sunny(0.05f));
  for (const int msaa : {1, 4}) {
    FrameRequest r = request("uniform");
    r.width = 90;  // tiles that reach beyond the picture
    r.msaa = msaa;
    std::vector<Image> pictures[2];
    for (const bool reuse : {false, true})
      for (int k = 0; k < 6; ++k) {
        r.env_rotation_rad = 0.25f * static_cast<float>(k);
        r.settings.set("shading.reuse", reuse);
        pictures[reuse].push_back(draw(r));
      }
    for (std::size_t k = 0; k < pictures[0].size(); ++k) {
      const std::vector<float>&anew = pictures[0][k].data, &turned = pictures[1][k].data;
      double sum = 0.0, apart = 0.0;
      for (std::size_t i = 0; i < anew.size(); ++i) {
        sum += static_cast<double>(anew[i]);
        apart = std::max(apart, static_cast<double>(std::abs(turned[i] - anew[i])));
      }
      EXPECT_LT(apart, 1e-3 * sum / static_cast<double>(anew.size())) << msaa << " " << k;
    }
  }
}

TEST_F(ShadowRays, ThePlanSaysWhatTheyDo) {
  renderer_.set_scene(std::make_shared<Scene>(floor_below(test::matte(glm::vec3(0.1f)))));
  renderer_.set_environment(sunny(1.0f));
  FrameRequest r = request("bandwidth");
  const auto has_pass = [&](const FrameStats& stats, const char* name) {
    return std::any_of(stats.plan.passes.begin(), stats.plan.passes.end(),
                       [&](const PlannedPass& pass) { return pass.name == name; });
  };
  renderer_.finish_background_work(r);
  EXPECT_TRUE(has_pass(renderer_.render(r), "trace_rays"));
  for (const char* visibility : {"none", "baked", "traced"}) {
    r.settings.set("shading.visibility", std::string(visibility));
    renderer_.finish_background_work(r);
    EXPECT_FALSE(has_pass(renderer_.render(r), "trace_rays")) << visibility;
  }
}

}  // namespace
}  // namespace maquette
