// The displayed picture: edges against a sky that is too bright for the display, in the window and in PNG.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "render/gl/context.h"
#include "render/gl/objects.h"
#include "render/renderer.h"

namespace maquette {
namespace {

constexpr int kWidth = 48, kHeight = 32;
constexpr double kSurface = 0.05;  ///< linear on the display, where the sky is 1,000 times as bright

double srgb(double v) { return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055; }

/// An unlit triangle whose edges are neither rows, columns nor diagonals.
std::shared_ptr<Scene> unlit_triangle() {
  auto scene = std::make_shared<Scene>();
  Material m;
  m.base_color = glm::vec4(glm::vec3(static_cast<float>(kSurface)), 1.0f);
  m.unlit = m.double_sided = true;
  scene->materials = {m};
  Primitive p;
  p.material = 0;
  p.positions = {{-0.61f, -0.43f, 0.0f}, {0.57f, -0.21f, 0.0f}, {0.13f, 0.53f, 0.0f}};
  p.normals.assign(3, {0.0f, 0.0f, 1.0f});
  p.indices = {0, 1, 2};
  scene->meshes.emplace_back();
  scene->meshes.back().primitives.push_back(p);
  Node node;
  node.mesh = 0;
  scene->nodes.push_back(node);
  scene->roots.push_back(0);
  return scene;
}

std::shared_ptr<const Environment> even_sky(float radiance) {
  auto sky = std::make_shared<Environment>();
  sky->width = 8;
  sky->height = 4;
  sky->rgb.assign(32, glm::vec3(radiance));
  return sky;
}

class Display : public ::testing::Test {
 protected:
  Display() {
    renderer_.set_scene(unlit_triangle());
    renderer_.set_environment(even_sky(1000.0f * static_cast<float>(kSurface)));
    request_.width = kWidth;
    request_.height = kHeight;
    request_.samples = 4;
    request_.camera.eye = {0.0f, 0.0f, 1.5f};
    request_.settings.set_from_text("shading.visibility", "none");
  }

  /// The picture as the window shows it.
  Image presented() {
    const Texture window = Texture::make_2d("window", GL_RGBA8, kWidth, kHeight);
    GLuint name = 0;
    glCreateFramebuffers(1, &name);
    const GlName<FramebufferTraits> framebuffer(name);
    glNamedFramebufferTexture(name, GL_COLOR_ATTACHMENT0, window.get(), 0);
    glBindFramebuffer(GL_FRAMEBUFFER, name);
    renderer_.present(0, 0, kWidth, kHeight, 0.0f, "linear");
    glBindFramebuffer(GL_FRAMEBUFFER, 0);
    Image bottom_up(kWidth, kHeight, 4), image(kWidth, kHeight, 4);
    glGetTextureImage(window.get(), 0, GL_RGBA, GL_FLOAT, static_cast<GLsizei>(image.data.size() * sizeof(float)),
                      bottom_up.data.data());
    for (int y = 0; y < kHeight; ++y)
      std::copy_n(&bottom_up.data[bottom_up.index(0, kHeight - 1 - y)], image.index(0, 1),
                  &image.data[image.index(0, y)]);
    return image;
  }

  /// Pixels with both surface and sky have the mean of both displayed values, weighted by their shares.
  void expect_smooth_edges(int points) {
    const Image radiance = renderer_.read_radiance(), display = renderer_.read_display(0.0f, "linear"),
                window = presented();
    int edges = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) {
        const double covered = static_cast<double>(radiance.at(x, y, 3));
        EXPECT_NEAR(covered * points, std::round(covered * points), 1e-4);
        edges += covered > 0.0 && covered < 1.0 ? 1 : 0;
        const double expected = srgb(covered * kSurface + (1.0 - covered));
        EXPECT_NEAR(static_cast<double>(display.at(x, y, 1)), expected, 2e-3) << x << ' ' << y << ' ' << covered;
        EXPECT_NEAR(static_cast<double>(window.at(x, y, 1)), expected, 2e-3 + 0.5 / 255.0) << x << ' ' << y;
      }
    EXPECT_GT(edges, 30);
  }

  GlContext context_ = GlContext::create_headless();
  Renderer renderer_;
  FrameRequest request_;
};

TEST_F(Display, EdgesAgainstADazzlingSkyAreSmooth) {
  for (const int points : {4, 16})
    for (const char* mode : {"bandwidth", "uniform", "splitsum"}) {
      SCOPED_TRACE(mode);
      request_.msaa = points;
      request_.mode = mode;
      renderer_.render(request_);
      expect_smooth_edges(points);
    }
}

TEST_F(Display, EdgesStaySmoothWhileThePictureConverges) {
  request_.msaa = 4;
  for (int frame = 0; frame < 3; ++frame) renderer_.render(request_, true);
  expect_smooth_edges(4);
}

/// One point a pixel, and means over frames whose points are not kept.
TEST_F(Display, WithoutPointsThePictureIsToneMapped) {
  renderer_.render(request_);
  EXPECT_EQ(renderer_.read_display(0.0f, "agx").data, tone_map(renderer_.read_radiance(), 0.0f, "agx").data);
  request_.msaa = 4;
  request_.mode = "uniform";
  for (int frame = 0; frame < 2; ++frame) renderer_.render(request_, true);
  EXPECT_EQ(renderer_.read_display(0.0f, "agx").data, tone_map(renderer_.read_radiance(), 0.0f, "agx").data);
}

}  // namespace
}  // namespace maquette
