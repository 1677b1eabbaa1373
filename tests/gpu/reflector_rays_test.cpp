// Rays of reflectors: exact even for a coarsely drawn patch, and none left from another frame.
#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include "render/gl/context.h"
#include "render/reflections/coarse_patches.h"
#include "render/renderer.h"
#include "scenes/environment_builtin.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

using test::add;
using test::make_grid;

constexpr float kBend = 0.15f;

/// A mirror z = -1 + kBend (x^2 + y^2 / 2), 2 m wide and 1.2 m high, before a wall at z = 3.
Scene mirror_before_wall() {
  Scene scene;
  Material grey, metal;
  grey.base_color = glm::vec4(0.5f, 0.5f, 0.5f, 1.0f);
  grey.metallic = 0.0f;
  grey.double_sided = metal.double_sided = true;
  metal.roughness = 0.02f;
  metal.metallic = 1.0f;
  scene.materials = {grey, metal};
  BezierPatch patch;
  patch.material = 1;
  // Control points of the polynomial: a quadratic's are its blossom, raised in degree.
  const auto square = [](int k) { return k == 0 || k == 3 ? 1.0f : -1.0f / 3.0f; };
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i)
      patch.points[static_cast<std::size_t>(4 * j + i)] = {-1.0f + 2.0f * static_cast<float>(i) / 3.0f,
                                                           0.6f * (-1.0f + 2.0f * static_cast<float>(j) / 3.0f),
                                                           -1.0f + kBend * (square(i) + 0.5f * 0.36f * square(j))};
  Node node;
  node.patch = 0;
  scene.patches.push_back(patch);
  scene.roots.push_back(0);
  scene.nodes.push_back(node);
  add(&scene, make_grid({-9.0f, -9.0f, 3.0f}, {18, 0, 0}, {0, 18, 0}, 4, 0), "wall");
  return scene;
}

FrameRequest rays_request(const std::string& technique, const std::string& resolution) {
  FrameRequest r;
  r.mode = "splitsum";
  r.width = 192;
  r.height = 128;
  r.reflections = technique;
  r.camera.eye = {0.0f, 0.0f, 1.8f};
  r.camera.target = {0.0f, 0.0f, -1.0f};
  r.camera.fov_y_rad = 0.5f;
  r.settings.set_from_text("reflections.resolution", resolution);
  return r;
}

/// The path from the eye on the z axis via the mirror to the wall.
double exact_distance_m(double eye_z, const glm::dvec3& ray) {
  // (eye_z + k) + 1 = kBend k^2 (x^2 + y^2 / 2) along z = eye_z - k.
  const double a = kBend * (ray.x * ray.x + 0.5 * ray.y * ray.y), depth = eye_z + 1.0;
  const double k = 2.0 * depth / (1.0 + std::sqrt(1.0 + 4.0 * a * depth));
  const glm::dvec3 at = glm::dvec3(0.0, 0.0, eye_z) + k * ray;
  const glm::dvec3 normal = glm::normalize(glm::dvec3(-2.0 * kBend * at.x, -kBend * at.y, 1.0));
  const glm::dvec3 mirrored = glm::reflect(glm::normalize(ray), normal);
  return k * glm::length(ray) + (3.0 - at.z) / mirrored.z;
}

class ReflectorRays : public ::testing::Test {
 protected:
  GlContext context_ = GlContext::create_headless();
  std::shared_ptr<Environment> sky_ = std::make_shared<Environment>(make_clear_sky());
  void SetUp() override { install_debug_output(); }
  std::unique_ptr<Renderer> make_renderer(const Scene& scene) {
    auto renderer = std::make_unique<Renderer>();
    renderer->set_environment(sky_);
    renderer->set_scene(std::make_shared<Scene>(scene));
    return renderer;
  }
};

/// Compared with the closed form, not with the triangles by which the patch is drawn.
TEST_F(ReflectorRays, OfACoarselyDrawnPatchAreExact) {
  const Scene scene = mirror_before_wall();
  const std::unique_ptr<Renderer> renderer = make_renderer(scene);
  for (const char* resolution : {"full", "half", "quarter"}) {
    SCOPED_TRACE(resolution);
    const FrameRequest request = rays_request("raytraced", resolution);
    renderer->render(request);
    const Image image = renderer->read_debug_view("reflection_distance");
    const double px = 2.0 * std::tan(0.5 * static_cast<double>(request.camera.fov_y_rad)) / image.height;
    const CoarsePatch::Level* level = coarsest_level(make_coarse_patches(flatten(scene)).of_item.at(0),
                                                     request.camera.eye, 0.1f * static_cast<float>(px));
    ASSERT_NE(level, nullptr);
    double worst = 0.0;
    int seen = 0;
    for (int y = 0; y < image.height; ++y)
      for (int x = 0; x < image.width; ++x) {
        if (image.at(x, y, 3) <= 0.0f) continue;
        ++seen;
        const glm::dvec3 ray(px * (x + 0.5 - 0.5 * image.width), px * (0.5 * image.height - y - 0.5), -1.0);
        const double expected = exact_distance_m(static_cast<double>(request.camera.eye.z), ray);
        worst = std::max(worst, std::abs(static_cast<double>(image.at(x, y, 0)) - expected) / expected);
      }
    EXPECT_LT(worst, 1e-5);
    EXPECT_GT(seen, image.width * image.height / 4);
  }
}

/// Only tiles with rays are drawn: old contents of other tiles must not be visible.
TEST_F(ReflectorRays, AJumpOfTheEyeLeavesNothingBehind) {
  const Scene scene = mirror_before_wall();
  const std::pair<const char*, const char*> cases[] = {
      {"raytraced", "splitsum"}, {"octree", "splitsum"}, {"octree", "bandwidth"}};
  for (const auto& [technique, mode] : cases) {
    SCOPED_TRACE(std::string(technique) + " " + mode);
    FrameRequest near = rays_request(technique, "half");
    near.mode = mode;
    FrameRequest far = near;
    far.camera.eye = {2.5f, 1.0f, 2.5f};
    far.camera.target = {1.0f, 0.3f, -1.0f};
    const auto draw = [&](Renderer* renderer, const FrameRequest& request) {
      EXPECT_TRUE(renderer->finish_background_work(request));
      renderer->render(request);
      return renderer->read_radiance();
    };
    const std::unique_ptr<Renderer> moved = make_renderer(scene), fresh = make_renderer(scene);
    draw(moved.get(), near);
    const Image after = draw(moved.get(), far);
    const Image view = moved->read_debug_view("reflection");
    EXPECT_EQ(after.data, draw(fresh.get(), far).data);
    EXPECT_EQ(view.data, fresh->read_debug_view("reflection").data);
  }
  const auto errors = take_gl_errors();
  EXPECT_TRUE(errors.empty()) << errors.front();
}

}  // namespace
}  // namespace maquette
