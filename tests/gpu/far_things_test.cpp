// Things that are far, and shadows of lamps in the sky: what pictures have at rest and when they are alone.
#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <numbers>

#include "render/gl/context.h"
#include "render/renderer.h"
#include "scenes/error.h"
#include "scenes/modelling.h"
#include "tests/support/path_scenes.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

class FarThings : public ::testing::Test {
 protected:
  GlContext context_ = GlContext::create_headless();
};

Image draw_picture(const Scene& scene, const std::shared_ptr<const Environment>& sky, const FrameRequest& request,
                   int frames) {
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>(scene));
  renderer.set_environment(sky);
  renderer.finish_background_work(request);
  for (int i = 0; i < frames; ++i) renderer.render(request, i > 0);
  return renderer.read_radiance();
}

/// A plate at 0.7 m of an eye at the origin, in a dome; the dome is seen from inside.
Scene plate_in_a_dome(double radius_m) {
  Scene scene;
  scene.materials = {test::matte(glm::vec3(0.25f)), test::matte(glm::vec3(0.9f))};
  scene.materials[0].unlit = scene.materials[1].unlit = true;
  scene.materials[1].double_sided = true;
  test::add(&scene, test::make_grid({-0.3f, -0.3f, -0.7f}, {0.6f, 0, 0}, {0, 0.6f, 0}, 1, 0));
  Primitive dome = modelling::make_sphere(radius_m, 4);
  dome.material = 1;
  if (radius_m > 0.0) test::add(&scene, std::move(dome));
  return scene;
}

TEST_F(FarThings, DoNotCutAwayWhatIsNear) {
  FrameRequest request;
  request.camera.eye = glm::vec3(0.0f);
  request.camera.target = {0.0f, 0.0f, -1.0f};
  request.camera.fov_y_rad = 1.6f;
  request.width = request.height = 16;
  request.samples = 16;
  for (const char* mode : {"bandwidth", "uniform", "splitsum", "sg", "reference"})
    for (const double radius_m : {50.0, 5000.0, 1e5}) {
      request.mode = mode;
      const Image picture = draw_picture(plate_in_a_dome(radius_m), test::constant_sky(1.0f), request, 1);
      EXPECT_NEAR(picture.at(8, 8, 0), 0.25f, 0.01f) << mode << ", dome of " << radius_m << " m";
      EXPECT_NEAR(picture.at(1, 1, 0), 0.9f, 0.02f) << mode << ", dome of " << radius_m << " m";
    }
}

/// A floor of two triangles below a black roof, under a sky that is black but for a lamp at the zenith.
Scene floor_below_a_roof() {
  Scene scene;
  scene.materials = {test::matte(glm::vec3(0.5f)), test::matte(glm::vec3(0.0f))};
  test::add(&scene, test::make_grid({-2, 0, 2}, {4, 0, 0}, {0, 0, -4}, 1, 0));
  test::add(&scene, test::make_grid({-0.5f, 1, -0.5f}, {1, 0, 0}, {0, 0, 1}, 1, 1), "roof");
  return scene;
}
std::shared_ptr<const Environment> sky_with_zenith_lamp(double degrees, double rest = 0.0) {
  const double least = std::cos(0.5 * degrees * std::numbers::pi / 180.0);
  return test::sky_of(256, 128, [=](const glm::dvec3& d) { return glm::dvec3(d.y > least ? 100.0 : rest); });
}
FrameRequest from_below_the_roof(const std::string& mode) {
  FrameRequest request;
  request.mode = mode;
  request.camera.eye = {0.0f, 0.9f, 0.0f};
  request.camera.target = glm::vec3(0.0f);
  request.camera.up = {0.0f, 0.0f, -1.0f};
  request.camera.height_m = 4.0f;
  request.width = request.height = 48;
  return request;
}
double shadow_difference(const Image& a, const Image& b) {
  double squares = 0.0, sum = 0.0;
  for (int y = 0; y < b.height; ++y)
    for (int x = 0; x < b.width; ++x) {
      squares += std::pow(static_cast<double>(a.at(x, y, 1) - b.at(x, y, 1)), 2.0);
      sum += static_cast<double>(b.at(x, y, 1));
    }
  const double pixels = static_cast<double>(b.width) * b.height;
  return std::sqrt(squares / pixels) / (sum / pixels);
}

TEST_F(FarThings, ALampsShadowOnTwoTrianglesConvergesInEveryModeThatSamples) {
  const Scene scene = floor_below_a_roof();
  for (const double degrees : {8.0, 40.0}) {
    const auto sky = sky_with_zenith_lamp(degrees);
    FrameRequest traced = from_below_the_roof("reference");
    traced.samples = 400;
    const Image truth = draw_picture(scene, sky, traced, 1);
    for (const char* mode : {"uniform", "bandwidth"}) {
      const FrameRequest request = from_below_the_roof(mode);
      const double few = shadow_difference(draw_picture(scene, sky, request, 24), truth);
      const double many = shadow_difference(draw_picture(scene, sky, request, 160), truth);
      EXPECT_LT(many, 0.04) << mode << ", lamp of " << degrees << " degrees";
      EXPECT_LT(many, 0.75 * few) << mode << ", lamp of " << degrees << " degrees";
    }
    for (const char* mode : {"uniform", "bandwidth"}) {
      FrameRequest request = from_below_the_roof(mode);
      request.single = true;
      const Image alone = draw_picture(scene, sky, request, 1);
      EXPECT_LT(shadow_difference(alone, truth), 0.15) << mode << ", one frame, " << degrees << " degrees";
    }
  }
}

/// Where frames are averaged, what rays take away in one of them may be more than it has.
TEST_F(FarThings, ALampBeforeABrightSkyConvergesToo) {
  const Scene scene = floor_below_a_roof();
  const auto sky = sky_with_zenith_lamp(20.0, 2.0);
  FrameRequest traced = from_below_the_roof("reference");
  traced.samples = 400;
  const Image truth = draw_picture(scene, sky, traced, 1);
  for (const char* mode : {"uniform", "bandwidth"})
    EXPECT_LT(shadow_difference(draw_picture(scene, sky, from_below_the_roof(mode), 160), truth), 0.02) << mode;
}

TEST_F(FarThings, AnEyeBeyondAllIsAnErrorAndNoCrash) {
  FrameRequest request;
  request.width = request.height = 8;
  for (const char* mode : {"reference", "bandwidth"})
    for (const float far : {1e20f, 3e38f, -1e13f}) {
      request.mode = mode;
      request.camera.eye = {far, 0.0f, 0.0f};
      request.camera.target = glm::vec3(0.0f);
      EXPECT_THROW(draw_picture(floor_below_a_roof(), test::constant_sky(1.0f), request, 1), Error) << far;
      std::swap(request.camera.eye, request.camera.target);
      EXPECT_THROW(draw_picture(floor_below_a_roof(), test::constant_sky(1.0f), request, 1), Error) << far;
    }
}

TEST_F(FarThings, TransferNamesThePartsThatItCannotHold) {
  const auto refused = [](const std::function<void(Scene*)>& change) {
    Scene scene;
    scene.materials.push_back(test::matte(glm::vec3(0.5f)));
    test::add(&scene, test::make_grid({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 2, 0), "plate");
    change(&scene);
    FrameRequest request;
    request.mode = "prt";
    request.width = request.height = 16;
    for (const auto& [name, value] : {std::pair{"prt.faces", 4}, {"prt.clusters", 4}, {"prt.components", 1}})
      request.settings.set(name, value);
    try {
      draw_picture(scene, test::constant_sky(1.0f), request, 1);
      return std::string();
    } catch (const Error& error) {
      return std::string(error.what());
    }
  };
  EXPECT_EQ(refused([](Scene*) {}), "");
  const auto colored = [](Scene* scene) {
    Primitive& p = scene->meshes[0].primitives[0];
    p.colors.assign(p.positions.size(), glm::vec4(1.0f));
    p.colors.back().x = 0.5f;
  };
  EXPECT_NE(refused(colored).find("part plate"), std::string::npos) << refused(colored);
  EXPECT_NE(refused([](Scene* scene) { scene->materials[0].double_sided = true; }).find("two-sided"),
            std::string::npos);
  EXPECT_EQ(refused([](Scene* scene) {
              scene->materials[0].double_sided = true;
              scene->meshes[0].primitives[0] = modelling::make_sphere(1.0, 3);
              scene->meshes[0].primitives[0].material = 0;
            }),
            "")
      << "nobody sees the back of what is closed";
  const auto nearest = [](Scene* scene) {
    scene->images.push_back(test::checkerboard());
    scene->materials[0].base_color_texture.image = 0;
    scene->materials[0].base_color_texture.nearest = true;
    Primitive& p = scene->meshes[0].primitives[0];
    for (const glm::vec3& at : p.positions) p.uvs[0].emplace_back(0.5f * at.x + 0.5f, 0.5f * at.y + 0.5f);
  };
  EXPECT_NE(refused(nearest).find("NEAREST"), std::string::npos) << refused(nearest);
}

}  // namespace
}  // namespace maquette
