// Scenes and the fixture of the tests of reflections.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "render/gl/context.h"
#include "render/metrics/metrics.h"
#include "render/renderer.h"
#include "scenes/environment_builtin.h"
#include "scenes/error.h"
#include "scenes/image_io.h"
#include "tests/support/test_scenes.h"

namespace maquette::test {

inline Material plain(const std::string& name, const glm::vec3& color) {
  Material m;
  m.name = name;
  m.base_color = glm::vec4(color, 1.0f);
  m.metallic = 0.0f;
  m.roughness = 0.9f;
  m.double_sided = true;
  return m;
}

inline Material mirror_metal() {
  Material m = plain("mirror", glm::vec3(0.9f));
  m.metallic = 1.0f;
  m.roughness = 0.02f;
  return m;
}

inline void add_box(Scene* scene, const glm::vec3& low, const glm::vec3& high, int material) {
  const glm::vec3 d = high - low, x(d.x, 0, 0), y(0, d.y, 0), z(0, 0, d.z);
  for (const Primitive& side : {make_grid(low, y, x, 2, material), make_grid(low, z, y, 2, material),
                                make_grid(low, x, z, 2, material), make_grid(high, -x, -y, 2, material),
                                make_grid(high, -y, -z, 2, material), make_grid(high, -z, -x, 2, material)})
    add(scene, side, "box");
}

/// The scene in front of the mirror: two boxes on a floor of two colours.
inline Scene room() {
  Scene scene;
  scene.materials = {plain("grey", glm::vec3(0.5f)), plain("red", {0.8f, 0.1f, 0.05f}),
                     plain("blue", {0.1f, 0.2f, 0.7f}), mirror_metal()};
  add(&scene, make_grid({-3.0f, -0.5f, 3.0f}, {3, 0, 0}, {0, 0, -3.9f}, 4, 0), "floor");
  add(&scene, make_grid({0.0f, -0.5f, 3.0f}, {3, 0, 0}, {0, 0, -3.9f}, 4, 2), "floor");
  add_box(&scene, {0.2f, -0.5f, -0.3f}, {0.6f, 0.1f, 0.1f}, 1);
  add_box(&scene, {-0.7f, -0.5f, 0.4f}, {-0.3f, 0.4f, 0.7f}, 2);
  return scene;
}

/// A mirror 2 m wide and 1.2 m high, curved towards the eye at its sides by `bend` metres.
inline void add_patch(Scene* scene, float bend) {
  BezierPatch patch;
  patch.name = "mirror";
  patch.material = 3;
  // Control points of the polynomial: a quadratic's are its blossom, raised in degree.
  const auto square = [](int k) { return k == 0 || k == 3 ? 1.0f : -1.0f / 3.0f; };
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) {
      const float x = -1.0f + 2.0f * static_cast<float>(i) / 3.0f,
                  y = 0.6f * (-1.0f + 2.0f * static_cast<float>(j) / 3.0f);
      patch.points[static_cast<std::size_t>(4 * j + i)] = {x, y, -1.0f + bend * (square(i) + 0.5f * 0.36f * square(j))};
    }
  Node node;
  node.name = "mirror";
  node.patch = static_cast<int>(scene->patches.size());
  scene->patches.push_back(patch);
  scene->roots.push_back(static_cast<int>(scene->nodes.size()));
  scene->nodes.push_back(node);
}

/// The same mirror as a mesh with normals.
inline void add_mesh_mirror(Scene* scene, float bend, int side) {
  Primitive p = make_grid({-1.0f, -0.6f, -1.0f}, {2, 0, 0}, {0, 1.2f, 0}, side, 3);
  for (std::size_t i = 0; i < p.positions.size(); ++i) {
    glm::vec3& at = p.positions[i];
    at.z += bend * (at.x * at.x + 0.5f * at.y * at.y);
    p.normals[i] = glm::normalize(glm::vec3(-2.0f * bend * at.x, -bend * at.y, 1.0f));
  }
  add(scene, p, "mirror")->reflector = true;
}

inline FrameRequest request_of(const std::string& technique) {
  FrameRequest r;
  r.mode = "splitsum";
  r.width = 192;
  r.height = 128;
  r.reflections = technique;
  r.camera.eye = {0.1f, 0.35f, 1.8f};
  r.camera.target = {0.0f, 0.0f, -1.0f};
  r.camera.fov_y_rad = 0.5f;
  r.settings.set_from_text("reflections.resolution", "full");
  return r;
}

inline Image draw_reflection(Renderer* renderer, const FrameRequest& request) {
  EXPECT_TRUE(renderer->finish_background_work(request));
  renderer->render(request);
  const Image image = renderer->read_debug_view("reflection");
  for (float v : image.data) EXPECT_TRUE(std::isfinite(v) && v >= 0.0f);
  const auto errors = take_gl_errors();
  EXPECT_TRUE(errors.empty()) << errors.front();
  return image;
}

struct Difference {
  double mean = 0.0;   ///< of the absolute difference, against the mean of the reference
  double share = 0.0;  ///< share of the reflector's pixels that differ by more than a tenth of that mean
};

inline Difference compare(const Image& image, const Image& reference) {
  double sum = 0.0, level = 0.0, count = 0.0, off = 0.0;
  const auto each = [&](auto&& use) {
    for (std::size_t i = 0; i < reference.data.size(); i += 4)
      if (reference.data[i + 3] > 0.0f) use(i);
  };
  each([&](std::size_t i) {
    for (std::size_t c = 0; c < 3; ++c) level += static_cast<double>(reference.data[i + c]) / 3.0;
    count += 1.0;
  });
  level /= count;
  each([&](std::size_t i) {
    EXPECT_GT(image.data[i + 3], 0.0f);
    double d = 0.0;
    for (std::size_t c = 0; c < 3; ++c)
      d += std::abs(static_cast<double>(image.data[i + c] - reference.data[i + c])) / 3.0;
    sum += d;
    off += d > 0.1 * level ? 1.0 : 0.0;
  });
  EXPECT_GT(count, 2000.0);
  EXPECT_GT(level, 0.0);
  return {sum / count / level, off / count};
}

class Reflections : public ::testing::Test {
 protected:
  GlContext context_ = GlContext::create_headless();
  Renderer renderer_;
  void SetUp() override {
    install_debug_output();
    renderer_.set_environment(std::make_shared<Environment>(make_clear_sky()));
  }
  /// Compares a technique with traced rays; pictures of a failure are written beside the test.
  void expect_near_rays(const FrameRequest& request, double mean, double share) {
    FrameRequest exact = request;
    exact.reflections = "raytraced";
    const Image image = draw_reflection(&renderer_, request), reference = draw_reflection(&renderer_, exact);
    const Difference d = compare(image, reference);
    EXPECT_LT(d.mean, mean);
    EXPECT_LT(d.share, share);
    if (d.mean < mean && d.share < share) return;
    const std::string name =
        ::testing::TempDir() + "reflections_" + request.reflections + "_" + std::to_string(written_++);
    save_png(name + ".png", debug_view_picture(image, "reflection"));
    save_png(name + "_reference.png", debug_view_picture(reference, "reflection"));
    ADD_FAILURE() << "pictures: " << name << "*.png";
  }
  int written_ = 0;
};

}  // namespace maquette::test
