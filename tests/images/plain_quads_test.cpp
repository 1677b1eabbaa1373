// With several points a pixel most quads are interpolated and completed as one (shaders/bandwidth/quads.comp):
// variation inside them must still be visible.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <string>

#include "render/gl/context.h"
#include "render/renderer.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

constexpr int kQuadsSide = 48;

Primitive wall(float z, int material) {
  Primitive p = test::make_grid({-2.0f, -2.0f, z}, {4.0f, 0, 0}, {0, 4.0f, 0}, 8, material);
  for (const glm::vec3& at : p.positions) p.uvs[0].push_back({at.x, at.y});
  return p;
}

/// An even, unlit wall: without noise, so that both modes must give the same picture.
Scene unlit_wall() {
  Scene scene;
  scene.materials = {test::matte(glm::vec3(0.8f))};
  scene.materials[0].unlit = true;
  test::add(&scene, wall(0.0f, 0));
  return scene;
}

/// Random texels of a third of a pixel's width.
void add_texture(Scene* scene) {
  TextureImage noise;
  noise.width = noise.height = 256;
  std::uint32_t state = 1;
  for (int i = 0; i < noise.width * noise.height; ++i) {
    state = state * 1664525u + 1013904223u;
    noise.rgba.insert(noise.rgba.end(), {static_cast<std::uint8_t>(state >> 24u), 128,
                                         static_cast<std::uint8_t>(255 - (state >> 24u)), 255});
  }
  scene->images.push_back(noise);
  scene->materials[0].base_color_texture.image = 0;
  scene->materials[0].base_color_texture.nearest = true;
}

/// The largest difference between mode `uniform` and several frames of mode `bandwidth`.
double largest_difference(Renderer& renderer, int msaa, bool accumulate) {
  FrameRequest r;
  r.camera.eye = {0.05f, 0.03f, 2.0f};
  r.width = r.height = kQuadsSide;
  r.samples = 4;
  r.msaa = msaa;
  r.settings.set_from_text("shading.visibility", "none");
  r.mode = "uniform";
  renderer.render(r);
  const Image expected = renderer.read_radiance();
  r.mode = "bandwidth";
  double largest = 0.0;
  for (int frame = 0; frame < 3; ++frame) {
    renderer.render(r, accumulate);
    const Image picture = renderer.read_radiance();
    for (std::size_t i = 0; i < picture.data.size(); ++i)
      largest = std::max(largest, std::abs(1.0 * picture.data[i] - expected.data[i]));
  }
  return largest;
}

void expect_same(const Scene& scene, double tolerance) {
  GlContext context = GlContext::create_headless();
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>(scene));
  renderer.set_environment(test::constant_sky(1.0f));
  for (const int msaa : {4, 16})
    for (const bool accumulate : {false, true})
      EXPECT_LT(largest_difference(renderer, msaa, accumulate), tolerance)
          << msaa << " points" << (accumulate ? ", resting" : "");
  EXPECT_TRUE(take_gl_errors().empty());
}

TEST(PlainQuads, ShowTheirTexels) {
  Scene scene = unlit_wall();
  add_texture(&scene);
  expect_same(scene, 2e-5);
}

TEST(PlainQuads, ShowTheColoursOfVertices) {
  Scene scene = unlit_wall();
  Primitive& p = scene.meshes[0].primitives[0];
  for (std::size_t i = 0; i < p.positions.size(); ++i)
    p.colors.emplace_back(i % 2 ? 1.0f : 0.1f, i % 3 ? 0.9f : 0.2f, i % 5 ? 0.3f : 1.0f, 1.0f);
  expect_same(scene, 2e-5);
}

/// A pane with edges over texels: drawn in the first frame and reused from then on.
TEST(PlainQuads, ShowWhatIsBehindPanes) {
  Scene scene = unlit_wall();
  add_texture(&scene);
  Material pane = test::matte(glm::vec3(0.5f, 0.7f, 0.9f));
  pane.glass = true;
  scene.materials.push_back(pane);
  test::add(&scene, test::make_grid({-0.31f, -0.27f, 0.4f}, {0.7f, 0.11f, 0}, {-0.07f, 0.6f, 0}, 2, 1));
  expect_same(scene, 0.1);  // inside the pixels of its edge texels are replaced by the mean of their quad
}

}  // namespace
}  // namespace maquette
