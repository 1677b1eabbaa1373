// The ground below a scene that has none: it shows the environment, catches shadows, and turns with it.
#include "scenes/ground.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "render/frame/camera.h"
#include "render/reference/path_scene.h"
#include "render/reference/reference.h"
#include "tests/support/path_scenes.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

TEST(Ground, IsThereWhereSomethingLevelLiesBelow) {
  for (const char* name : {"cockpit", "plate", "cornell"}) EXPECT_TRUE(has_ground(build_builtin_scene(name))) << name;
  EXPECT_FALSE(has_ground(build_builtin_scene("sphere")));
  EXPECT_TRUE(has_ground(Scene()));
  Scene table;  // a level top that is not at the bottom
  table.materials = {test::matte(glm::vec3(0.5f))};
  test::add(&table, test::make_grid({-1, 1, 1}, {2, 0, 0}, {0, 0, -2}, 2, 0));
  EXPECT_TRUE(has_ground(table)) << "a plane alone is its own ground";
  test::add(&table, test::make_grid({0, 0, 0}, {0.1f, 0, 0}, {0, 1, 0}, 1, 0));
  EXPECT_FALSE(has_ground(table));
  add_ground(&table, *test::constant_sky(1.0f), {});
  EXPECT_TRUE(has_ground(table));
  EXPECT_TRUE(is_added_ground(table, table.nodes.size() - 1));
  const std::size_t nodes = table.nodes.size(), images = table.images.size();
  remove_ground(&table);
  EXPECT_EQ(table.nodes.size(), nodes - 1);
  EXPECT_EQ(table.images.size(), images - 1);
  remove_ground(&table);  // the file's own parts stay
  EXPECT_EQ(table.nodes.size(), nodes - 1);
}

TEST(Ground, IrradianceOfTheUpperHalfAgreesWithClosedForms) {
  EXPECT_NEAR(upper_irradiance(*test::constant_sky(3.0f)).x, 3.0 * std::numbers::pi, 1e-6);
  // L = sin(latitude) above: 2 pi / 3.
  const auto sine = test::sky_of(64, 512, [](const glm::dvec3& d) { return glm::dvec3(std::max(d.y, 0.0)); });
  EXPECT_NEAR(upper_irradiance(*sine).x, 2.0 * std::numbers::pi / 3.0, 1e-4);
  const auto odd = test::sky_of(8, 5, [](const glm::dvec3&) { return glm::dvec3(1.0); });  // the horizon cuts a row
  EXPECT_NEAR(upper_irradiance(*odd).x, std::numbers::pi, 1e-6);
}

/// Sky above, and below it patches of brightness, none brighter than a ground could be.
std::shared_ptr<const Environment> patchy() {
  return test::sky_of(256, 128, [](const glm::dvec3& d) {
    if (d.y > 0.0) return glm::dvec3(4.0, 5.0, 8.0);
    const double a = std::atan2(d.x, d.z);
    return glm::dvec3(0.8 + 0.5 * std::sin(2.0 * a), 1.0, 1.2 + 0.5 * std::cos(a));
  });
}

/// From the point of view of the environment, the ground looks as the environment does there, in every direction and at
/// each rotation. By the path tracer's direct light; what stands on it is a speck.
TEST(Ground, ShowsTheEnvironmentFromItsPointOfView) {
  const auto sky = patchy();
  for (const float rotation : {0.0f, 0.6f}) {
    Scene scene;
    scene.materials = {test::matte(glm::vec3(0.5f))};
    test::add(&scene, test::make_grid({0, 0, 0}, {1e-3f, 0, 0}, {0, 1e-3f, 0}, 1, 0));
    add_ground(&scene, *sky, {.height_m = 2.0f});
    scene.materials.back().base_color_texture.offset = ground_texture_offset(rotation);
    PictureRequest request;
    request.width = request.height = 24;
    request.paths.transport = Transport::direct;
    request.paths.env_rotation_rad = rotation;
    request.camera.eye = {0.0f, 2.0f, 0.0f};
    request.camera.target = request.camera.eye + glm::vec3(0.3f, -0.5f, 1.0f);
    request.camera.fov_y_rad = 0.8f;
    ReferencePicture picture(build_path_scene({.scene = scene, .environment = sky}), request);
    ASSERT_TRUE(picture.add(256));
    const Image seen = picture.mean();
    const CameraFrame camera = make_camera_frame(request.camera, 24, 24, compute_bounds(scene));
    double difference = 0.0, count = 0.0;
    for (int y = 0; y < 24; ++y)
      for (int x = 0; x < 24; ++x) {
        const EyeRay ray = camera.ray_through({2.0f * (static_cast<float>(x) + 0.5f) / 24.0f - 1.0f,
                                               1.0f - 2.0f * (static_cast<float>(y) + 0.5f) / 24.0f});
        const glm::dvec3 d = glm::normalize(glm::dvec3(ray.direction));
        if (d.y > -0.1) continue;
        const double c = std::cos(static_cast<double>(rotation)), s = std::sin(static_cast<double>(rotation));
        const glm::dvec3 expected =
            evaluate_environment(*sky, {c * d.x - s * d.z, d.y, s * d.x + c * d.z});  // turned back about +Y
        for (int k : {0, 1, 2}) difference += std::abs(static_cast<double>(seen.at(x, y, k)) / expected[k] - 1.0) / 3.0;
        count += 1.0;
      }
    ASSERT_GT(count, 300.0);
    EXPECT_LT(difference / count, 0.03) << rotation;
  }
}

}  // namespace
}  // namespace maquette
