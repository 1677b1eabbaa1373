// Octree reflections with cell BRDFs, against rays.
#include <gtest/gtest.h>

#include <cmath>
#include <memory>

#include "render/gl/context.h"
#include "render/renderer.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

using test::add;
using test::constant_sky;
using test::make_grid;
using test::matte;

/// A flat mirror that faces a white floor and, when `comb`, a comb of thin red plates on it, finer than a cell.
Scene before_a_mirror(bool comb) {
  Scene scene;
  Material mirror = matte(glm::vec3(0.95f));
  mirror.metallic = 1.0f;
  mirror.roughness = 0.02f;
  scene.materials = {matte(glm::vec3(0.8f)), matte({0.8f, 0.1f, 0.1f}), mirror};
  for (Material& m : scene.materials) m.double_sided = true;
  add(&scene, make_grid({-2.0f, -0.5f, 3.0f}, {4, 0, 0}, {0, 0, -3.8f}, 8, 0), "floor");
  for (int k = 0; comb && k < 15; ++k) {
    const float z = -0.4f + 0.13f * static_cast<float>(k);
    add(&scene, make_grid({-0.8f, -0.5f, z}, {1.6f, 0, 0}, {0, 0.025f, 0}, 1, 1), "plate");
  }
  add(&scene, make_grid({-1.0f, -0.6f, -1.0f}, {2, 0, 0}, {0, 1.2f, 0}, 1, 2), "mirror")->reflector = true;
  return scene;
}

class CellBrdfReflections : public ::testing::Test {
 protected:
  GlContext context_ = GlContext::create_headless();
  Renderer renderer_;
  FrameStats stats_;
  void SetUp() override { install_debug_output(); }

  Image draw(const std::string& technique, const std::string& brdf, int samples = 256) {
    FrameRequest r;
    r.mode = "uniform";
    r.samples = 64;
    r.width = 96;
    r.height = 64;
    r.reflections = technique;
    r.camera.eye = {0.1f, 0.5f, 1.8f};
    r.camera.target = {0.0f, 0.0f, -1.0f};
    r.camera.fov_y_rad = 0.5f;
    r.settings.set_from_text("reflections.resolution", "full");
    r.settings.set_from_text("reflections.samples", std::to_string(samples));
    r.settings.set_from_text("shading.visibility", "none");
    r.settings.set_from_text("octree.depth", "6");
    r.settings.set_from_text("octree.brdf", brdf);
    r.settings.set_from_text("octree.detail", "0");  // cells of one size, with BRDFs and without
    EXPECT_TRUE(renderer_.finish_background_work(r));
    stats_ = renderer_.render(r);
    const Image image = renderer_.read_debug_view("reflection");
    for (float v : image.data) EXPECT_TRUE(std::isfinite(v) && v >= 0.0f);
    const auto errors = take_gl_errors();
    EXPECT_TRUE(errors.empty()) << errors.front();
    return image;
  }
};

glm::vec3 mean_of(const Image& image, int y0, int y1) {
  glm::vec3 sum(0.0f);
  float count = 0.0f;
  for (int y = y0; y < y1; ++y)
    for (int x = image.width / 4; x < 3 * image.width / 4; ++x) {
      const float* p = image.data.data() + 4 * (y * image.width + x);
      if (p[0] + p[1] + p[2] <= 0.0f) continue;
      sum += glm::vec3(p[0], p[1], p[2]);
      count += 1.0f;
    }
  return sum / std::max(count, 1.0f);
}

/// A flat floor shaded by the BRDFs of its cells looks the same as shaded by its material: Lambert under an even sky.
TEST_F(CellBrdfReflections, FlatLambertCellsAreLambert) {
  renderer_.set_scene(std::make_shared<const Scene>(before_a_mirror(false)));
  renderer_.set_environment(constant_sky(1.0f));
  const glm::vec3 own = mean_of(draw("octree", "none"), 0, 64);
  EXPECT_EQ(stats_.gpu_bytes.count("cell_brdfs"), 0u);
  const glm::vec3 cells = mean_of(draw("octree", "all"), 0, 64);
  EXPECT_GT(stats_.gpu_bytes.at("cell_brdfs"), 0u);
  EXPECT_GT(stats_.technique.at("cell_layers"), 0.0);
  EXPECT_NEAR(cells.g, own.g, 0.05f * own.g);
  // mixed: the flat cells' BRDFs are not used
  const glm::vec3 mixed = mean_of(draw("octree", "mixed"), 0, 64);
  EXPECT_NEAR(mixed.g, own.g, 0.01f * own.g);
}

/// Plates lower than a cell: without BRDFs their cells show the floor, with them they are red from the side.
TEST_F(CellBrdfReflections, FineStructureKeepsItsMeanColour) {
  renderer_.set_scene(std::make_shared<const Scene>(before_a_mirror(true)));
  renderer_.set_environment(constant_sky(1.0f));
  const Image rays = draw("raytraced", "none");
  const glm::vec3 truth = mean_of(rays, 0, 64), boxes = mean_of(draw("octree", "none"), 0, 64);
  const glm::vec3 cells = mean_of(draw("octree", "mixed"), 0, 64);
  EXPECT_GT(stats_.technique["cell_layers"], 100.0);
  const float before = std::abs(boxes.g / boxes.r - truth.g / truth.r),
              after = std::abs(cells.g / cells.r - truth.g / truth.r);
  EXPECT_LT(after, 0.7f * before) << truth.r << " " << cells.r << " " << boxes.r << " " << truth.g / truth.r << " "
                                  << boxes.g / boxes.r << " " << cells.g / cells.r;
}

}  // namespace
}  // namespace maquette
