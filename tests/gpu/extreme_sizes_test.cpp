// The smallest and the largest picture, and the largest environment.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <memory>
#include <string>
#include <utility>

#include "render/gl/context.h"
#include "render/metrics/metrics.h"
#include "render/renderer.h"
#include "render/shading/work_lists.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

Image draw_sphere(const std::string& mode, int width, int height, std::shared_ptr<const Environment> sky) {
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>(load_scene("builtin:sphere")));
  renderer.set_environment(std::move(sky));
  FrameRequest request;
  request.mode = mode;
  request.camera.eye = {0.0f, 0.0f, 3.0f};
  request.camera.fov_y_rad = 0.3f;  // the middle of the picture is the sphere's
  request.width = width;
  request.height = height;
  request.samples = 2;
  renderer.render(request);
  return renderer.read_radiance();
}

bool is_sound(const Image& image) {
  return std::ranges::all_of(image.data, [](float v) { return std::isfinite(v) && v >= 0.0f; });
}

void expect_no_gl_errors() {
  const auto errors = take_gl_errors();
  EXPECT_TRUE(errors.empty()) << errors.front();
}

class ExtremeSizes : public ::testing::TestWithParam<std::string> {
 protected:
  void SetUp() override { install_debug_output(); }
  void TearDown() override { expect_no_gl_errors(); }
  GlContext context_ = GlContext::create_headless();
};
INSTANTIATE_TEST_SUITE_P(Modes, ExtremeSizes, ::testing::Values("uniform", "bandwidth", "splitsum", "sg"),
                         [](const auto& mode) { return mode.param; });

TEST_P(ExtremeSizes, OnePixelAndThinPicturesAreFinite) {
  const auto sky = std::make_shared<Environment>(load_environment("builtin:studio"));
  for (const auto& [width, height] : {std::pair{1, 1}, {2, 1}, {1, 9}, {301, 1}}) {
    const Image image = draw_sphere(GetParam(), width, height, sky);
    ASSERT_EQ(std::pair(image.width, image.height), std::pair(width, height));
    EXPECT_TRUE(is_sound(image)) << width << " x " << height;
    const float* middle = &image.data[static_cast<std::size_t>(4 * (height / 2 * width + width / 2))];
    EXPECT_EQ(middle[3], 1.0f) << width << " x " << height;
    EXPECT_GT(middle[1], 0.0f) << width << " x " << height;
  }
}

class SceneSizes : public ExtremeSizes {};
INSTANTIATE_TEST_SUITE_P(Modes, SceneSizes, ::testing::Values("uniform", "bandwidth"),
                         [](const auto& mode) { return mode.param; });

TEST_P(SceneSizes, BakedVisibilityDoesNotDependOnThem) {
  // An open box of triangles as fine as a car's: 1.5 cm, and 1.5e-8 m where the scene is that small.
  const auto picture = [&](float scale) {
    Scene scene = test::box_scene(5, 128, test::matte(glm::vec3(0.5f)));
    for (const int root : scene.roots) {
      glm::mat4& local = scene.nodes[static_cast<std::size_t>(root)].local;
      local = glm::mat4(glm::mat3(scale)) * local;
    }
    Renderer renderer;
    renderer.set_scene(std::make_shared<Scene>(std::move(scene)));
    renderer.set_environment(test::constant_sky(1.0f));
    FrameRequest request;
    request.mode = GetParam();
    request.width = 64;
    request.height = 40;
    request.samples = 64;
    request.camera = {.eye = glm::vec3(0.6f, 0.8f, 0.9f) * scale, .target = glm::vec3(-0.2f, -0.8f, -0.4f) * scale};
    request.settings.set_from_text("shading.visibility", "baked");
    request.settings.set_from_text("shading.indirect", "none");
    EXPECT_TRUE(renderer.finish_background_work(request));
    renderer.render(request);
    return renderer.read_radiance();
  };
  const Image one = picture(1.0f);
  for (const float scale : {1e-6f, 1e6f}) {
    const double error = compare_images(picture(scale), one).relative_rmse.value();
    EXPECT_LT(error, 0.02) << scale;
  }
}

class LargePicture : public ::testing::Test {
 protected:
  void SetUp() override { install_debug_output(); }
  void TearDown() override { expect_no_gl_errors(); }
  GlContext context_ = GlContext::create_headless();
};

TEST_F(LargePicture, EightThousandPixelsWideIsComplete) {
  const auto sky = std::make_shared<Environment>(load_environment("builtin:studio"));
  const Image image = draw_sphere("bandwidth", 7680, 4320, sky);
  ASSERT_EQ(image.width, 7680);
  ASSERT_EQ(image.height, 4320);
  EXPECT_TRUE(is_sound(image));
  // Every pixel shows the sphere and some light of the studio: no pass may be cut short by the length of a list.
  for (std::size_t i = 0; i < image.data.size(); i += 4) {
    ASSERT_EQ(image.data[i + 3], 1.0f) << "pixel " << i / 4;
    ASSERT_GT(image.data[i + 1], 0.0f) << "pixel " << i / 4;
  }
}

/// Rows of run lengths (a count over 128, then the value), each plane constant but for one hot texel's exponent.
void write_large_radiance(const std::string& path, int width, int height, int hot_x, int hot_y) {
  std::ofstream file(path, std::ios::binary);
  file << "#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y " << height << " +X " << width << '\n';
  const auto runs = [](std::string* row, int count, unsigned char value) {
    for (; count > 0; count -= 127) {
      row->push_back(static_cast<char>(128 + std::min(count, 127)));
      row->push_back(static_cast<char>(value));
    }
  };
  for (int y = 0; y < height; ++y) {
    std::string row{2, 2, static_cast<char>(width >> 8), static_cast<char>(width & 255)};
    for (int plane = 0; plane < 3; ++plane) runs(&row, width, 128);
    runs(&row, y == hot_y ? hot_x : width, 129);
    if (y == hot_y) {
      runs(&row, 1, 149);
      runs(&row, width - hot_x - 1, 129);
    }
    file.write(row.data(), static_cast<std::streamsize>(row.size()));
  }
}

TEST_F(LargePicture, SixteenThousandTexelEnvironmentKeepsItsEnergy) {
  const std::string path = (std::filesystem::path(::testing::TempDir()) / "sky_16k.hdr").string();
  write_large_radiance(path, 16384, 8192, 5000, 4096);
  const auto sky = std::make_shared<Environment>(load_environment(path));
  std::filesystem::remove(path);
  ASSERT_EQ(sky->warnings.size(), 1u);
  EXPECT_NE(sky->warnings[0].find("16384 x 8192"), std::string::npos) << sky->warnings[0];
  double sum = 0.0;
  for (const glm::vec3& rgb : sky->rgb) sum += rgb.x;
  // 128 x 2^(129 - 136) = 1 everywhere; 2^20 in one texel of 16384 x 8192.
  EXPECT_NEAR(sum / static_cast<double>(sky->rgb.size()), 1.0 + 1048575.0 / (16384.0 * 8192.0), 1e-4);
  const Image image = draw_sphere("bandwidth", 64, 64, sky);
  EXPECT_TRUE(is_sound(image));
}

TEST(WorkLists, AreLongEnoughForEveryPass) {
  const GlContext context = GlContext::create_headless();
  for (const auto& [width, height] : {std::pair{1, 1}, {7680, 1}, {640, 360}, {301, 977}})
    for (const int side : {1, 2})
      for (const bool bandwidth : {false, true}) {
        const GridSize size{width, height, side};
        const WorkLists t = make_work_lists(size, bandwidth);
        EXPECT_GE(t.capacity, 4 * kMostReflectedItems * size.grid_width()) << "four rows of what is reflected";
        EXPECT_GE(t.most, t.capacity);
        EXPECT_LE(t.most, (1 << 27) / 16) << "a storage buffer";
        const int all_quads = (size.grid_width() + 1) / 2 * ((size.grid_height() + 1) / 2);
        const int quads = bandwidth ? all_quads / (side > 1 ? 4 : 1) : 0;
        EXPECT_GE(t.items[1].bytes(), static_cast<std::size_t>(8 * std::max(quads, t.capacity)));
      }
}

/// Work lists grow to the size that frames have needed.
TEST(WorkLists, GrowWithoutLosingASample) {
  const GlContext context = GlContext::create_headless();
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>(load_scene("builtin:sphere")));
  renderer.set_environment(std::make_shared<Environment>(load_environment("builtin:studio")));
  FrameRequest request;
  request.camera.eye = {0.0f, 0.0f, 3.0f};
  request.camera.fov_y_rad = 0.3f;
  request.width = request.height = 64;
  request.settings.set_from_text("bandwidth.max_level", "0");
  request.settings.set_from_text("shading.reuse", "false");
  EXPECT_TRUE(renderer.finish_background_work(request));
  request.samples = 4;
  const std::size_t before = renderer.render(request).gpu_bytes.at("shading");
  request.samples = 1024;
  const FrameStats grown = renderer.render(request);
  const Image first = renderer.read_radiance();
  EXPECT_GT(grown.gpu_bytes.at("shading"), before);
  EXPECT_GT(static_cast<double>(grown.shading_samples), 0.8 * 1024.0 * 64.0 * 64.0);
  const FrameStats again = renderer.render(request);
  EXPECT_EQ(again.shading_samples, grown.shading_samples);
  EXPECT_EQ(again.gpu_bytes.at("shading"), grown.gpu_bytes.at("shading"));
  EXPECT_EQ(renderer.read_radiance().data, first.data);
  expect_no_gl_errors();
}

}  // namespace
}  // namespace maquette
