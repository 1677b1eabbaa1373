// The small inputs of ../shared/data/cases, each with the value that its format's specification gives; skipped without.
#include <gtest/gtest.h>

#include <exception>
#include <filesystem>

#include "render/gl/context.h"
#include "render/renderer.h"
#include "scenes/angles.h"
#include "scenes/error.h"
#include "scenes/image_io.h"
#include "test_paths.h"
#include "tests/support/test_scenes.h"
#include "viewer/session.h"

namespace maquette {
namespace {

const std::filesystem::path kCases = std::filesystem::path(MAQUETTE_SOURCE_DIR) / "../shared/data/cases";

struct SharedCase {
  const char* file;
  bool black_sky;  ///< else of radiance 1
  glm::ivec2 pixel{};
  glm::vec3 value{};  ///< cd/m2; of a view: what it shows
  float tolerance;
  const char* view = "";
  std::string camera = {};  ///< of the file; else the one of the folder's README
};

constexpr glm::ivec2 kMiddle{20, 20};
constexpr glm::vec3 kRed{1, 0, 0}, kGreen{0, 1, 0}, kBlue{0, 0, 1}, kOver{0.25f, 0.75f, 0.0f},
    kPlain{0.5f, 0.25f, 0.125f};
constexpr float kSlope = 0.70711f;

const SharedCase kAll[] = {
    {"02-flat-normals/tent.gltf", false, {10, 20}, {-kSlope, 0, kSlope}, 0.01f, "normal"},
    {"02-flat-normals/tent.gltf", false, {19, 20}, {-kSlope, 0, kSlope}, 0.01f, "normal"},
    {"02-flat-normals/tent.gltf", false, {30, 20}, {kSlope, 0, kSlope}, 0.01f, "normal"},
    {"03-mask-alpha/factor-hidden.gltf", false, kMiddle, kGreen, 0.01f},
    {"03-mask-alpha/color-hidden.gltf", false, kMiddle, kGreen, 0.01f},
    {"03-mask-alpha/color-times-texture-hidden.gltf", false, kMiddle, kGreen, 0.01f},
    {"03-mask-alpha/cutoff-above-one.gltf", false, kMiddle, kGreen, 0.01f},
    {"03-mask-alpha/factor-shown.gltf", false, kMiddle, kRed, 0.01f},
    {"03-mask-alpha/color-shown.gltf", false, kMiddle, kRed, 0.01f},
    {"03-mask-alpha/cutoff-zero.gltf", false, kMiddle, kRed, 0.01f},
    {"03-mask-alpha/blend-factor.gltf", false, kMiddle, kOver, 0.01f},
    {"03-mask-alpha/blend-color.gltf", false, kMiddle, kOver, 0.01f},
    {"03-mask-alpha/blend-color-texture.gltf", false, kMiddle, kOver, 0.01f},
    {"05-occlusion/with.gltf", true, kMiddle, glm::vec3(0.49f), 0.01f},
    {"05-occlusion/without.gltf", true, kMiddle, glm::vec3(0.49f), 0.01f},
    {"06-unlit-occlusion/plain.gltf", false, kMiddle, kPlain, 0.005f},
    {"06-unlit-occlusion/occlusion.gltf", false, kMiddle, kPlain, 0.005f},
    {"06-unlit-occlusion/emissive.gltf", false, kMiddle, kPlain, 0.005f},
    {"07-normalmap-uv1/set0.gltf", false, kMiddle, {0.6f, 0.0f, 0.8f}, 0.01f, "normal"},
    {"07-normalmap-uv1/set1.gltf", false, kMiddle, {0.0f, 0.6f, 0.8f}, 0.01f, "normal"},
    {"07-normalmap-uv1/set1-only.gltf", false, kMiddle, {0.0f, 0.6f, 0.8f}, 0.01f, "normal"},
    {"09-spot-cones/default.gltf", true, kMiddle, glm::vec3(0.49f), 0.01f},
    {"09-spot-cones/equal.gltf", true, kMiddle, glm::vec3(0.49f), 0.01f},
    {"09-spot-cones/beyond-90.gltf", true, kMiddle, glm::vec3(0.49f), 0.01f},
    {"09-spot-cones/inner-beyond-outer.gltf", true, kMiddle, glm::vec3(0.49f), 0.01f},
    {"09-spot-cones/inner-above-default-outer.gltf", true, kMiddle, glm::vec3(0.49f), 0.01f},
    {"09-spot-cones/outer-missing.gltf", true, kMiddle, glm::vec3(0.49f), 0.01f},
    {"14-vertex-colour-precision/float-0.003.gltf", false, kMiddle, glm::vec3(0.003f), 0.00006f},
    {"14-vertex-colour-precision/short-0.003.gltf", false, kMiddle, glm::vec3(0.003f), 0.00006f},
    {"14-vertex-colour-precision/float-0.0055.gltf", false, kMiddle, glm::vec3(0.0055f), 0.00011f},
    {"14-vertex-colour-precision/short-0.0055.gltf", false, kMiddle, glm::vec3(0.0055f), 0.00011f},
    {"14-vertex-colour-precision/float-0.02.gltf", false, kMiddle, glm::vec3(0.02f), 0.0004f},
    {"14-vertex-colour-precision/short-0.02.gltf", false, kMiddle, glm::vec3(0.02f), 0.0004f},
    {"28-blend-surface/emissive-blend.gltf", true, {8, 20}, glm::vec3(0.0f), 0.001f},
    {"28-blend-surface/emissive-blend.gltf", true, {32, 20}, glm::vec3(1.0f), 0.01f},
    {"28-blend-surface/emissive-opaque.gltf", true, {32, 20}, glm::vec3(1.0f), 0.01f},
    {"28-blend-surface/light-blend.gltf", true, kMiddle, glm::vec3(0.49f), 0.01f},
    {"28-blend-surface/color-blend.gltf", false, kMiddle, kPlain, 0.01f},
    {"28-blend-surface/metal-blend.gltf", false, kMiddle, glm::vec3(0.154f), 0.01f},
    {"28-blend-surface/metal-opaque.gltf", false, kMiddle, glm::vec3(0.154f), 0.01f},
};

class SharedCases : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kCases)) GTEST_SKIP() << "there is no " << kCases;
  }

  glm::vec3 draw(const SharedCase& c, const std::string& mode, const std::string& transport) {
    Renderer renderer;
    renderer.set_scene(std::make_shared<Scene>(load_scene((kCases / c.file).string())));
    renderer.set_environment(test::constant_sky(c.black_sky ? 0.0f : 1.0f));
    FrameRequest r;
    r.mode = mode;
    r.width = r.height = 40;
    r.samples = 256;
    r.camera.fov_y_rad = static_cast<float>(radians(30.0));
    if (!c.camera.empty()) {
      SceneOptions given;
      given.camera = c.camera;
      r.camera = camera_of_options(renderer.scene(), given);
    }
    if (!transport.empty()) r.settings.set("reference.transport", std::string(transport));
    renderer.render(r);
    const std::string view = c.view;
    const Image image = view.empty() ? renderer.read_radiance() : renderer.read_debug_view(view);
    const int channels = std::min(image.channels, 3);
    glm::vec3 sum(0.0f);
    for (int k = 0; k < channels; ++k) sum[k] = image.at(c.pixel.x, c.pixel.y, k);
    return sum;
  }

  GlContext context_ = GlContext::create_headless();
};

TEST_F(SharedCases, HaveTheValuesOfTheirSpecifications) {
  const std::pair<const char*, const char*> modes[] = {{"uniform", ""}, {"bandwidth", ""},       {"splitsum", ""},
                                                       {"sg", ""},      {"reference", "direct"}, {"reference", "full"}};
  for (const SharedCase& c : kAll) {
    // Modes that look up have no lights.
    for (const auto& [mode, transport] : modes) {
      const bool looks_up = std::string(mode) == "splitsum" || std::string(mode) == "sg";
      const bool traced = std::string(mode) == "reference";
      if ((looks_up && c.black_sky && std::string(c.file).find("emissive") == std::string::npos) || (traced && *c.view))
        continue;
      glm::vec3 value(0.0f);
      try {
        value = draw(c, mode, transport);
      } catch (const std::exception& error) {
        ADD_FAILURE() << c.file << ": " << error.what();
        break;
      }
      // Lookups and few paths have errors of their own.
      const float tolerance = c.tolerance * (looks_up ? 3.0f : 1.0f);
      const float noise = std::string(transport) == "full" ? 0.02f : 0.0f;
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(value[k], c.value[k], tolerance + noise * c.value[k])
            << c.file << " in " << mode << " " << transport << ", channel " << k;
    }
  }
}

TEST_F(SharedCases, FilesOfEverySpellingLoad) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(kCases / "17-uris-and-containers")) {
    if (entry.path().extension() != ".gltf" && entry.path().extension() != ".glb") continue;
    ++count;
    const std::string file = std::filesystem::relative(entry.path(), kCases).string();
    const glm::vec3 value = draw({file.c_str(), false, kMiddle, kPlain, 0.01f}, "uniform", "");
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(value[k], kPlain[k], 0.01f) << file << ", channel " << k;
  }
  EXPECT_GT(count, 10);
}

TEST_F(SharedCases, CamerasShowTheSceneOrAreLeftOut) {
  for (const char* name : {"infinite", "ortho", "scaled", "twice", "zfar-near"}) {
    const std::string file = std::string("24-cameras/") + name + ".gltf";
    const Scene scene = load_scene((kCases / file).string());
    ASSERT_FALSE(scene.cameras.empty()) << file;
    for (const auto& [x, color] : {std::pair(14, kRed), std::pair(26, kBlue)}) {
      const std::string& first = scene.cameras[0].name;
      const glm::vec3 value = draw({file.c_str(), false, {x, 20}, color, 0.01f, "", first}, "uniform", "");
      for (int k = 0; k < 3; ++k) EXPECT_NEAR(value[k], color[k], 0.01f) << file << ", " << first << ", " << x;
    }
  }
  for (const char* name : {"yfov-zero", "zfar-below", "znear-zero"}) {
    const std::string file = std::string("24-cameras/") + name + ".gltf";
    EXPECT_EQ(load_scene((kCases / file).string()).warnings.size(), 1u) << file;
  }
}

/// What pictures hold, whatever their layout says; warnings do not matter here.
TEST_F(SharedCases, PicturesHaveTheirValues) {
  const auto load = [](const std::string& file) { return load_hdr_image((kCases / file).string()); };
  const auto expect_same = [&](const std::string& file, const Image& value, float factor, float tolerance) {
    const Image found = load(file);
    ASSERT_EQ(found.width, value.width) << file;
    ASSERT_EQ(found.height, value.height) << file;
    for (int y = 0; y < value.height; ++y)
      for (int x = 0; x < value.width; ++x)
        for (int c = 0; c < 3; ++c)
          ASSERT_NEAR(found.at(x, y, c), factor * value.at(x, y, c), tolerance) << file << " at " << x << ", " << y;
  };
  const Image whole = load("11-exr-windows/whole.exr"), plain = load("13-radiance-header/plain.hdr");
  EXPECT_EQ(whole.width, 8);
  EXPECT_EQ(whole.height, 4);
  for (const char* name : {"cropped", "overscan"})
    expect_same(std::string("11-exr-windows/") + name + ".exr", whole, 1.0f, 0.0f);
  const Image rgb = load("12-exr-multipart-yc/rgb.exr");
  const glm::vec3 stored(0.2f, 0.5f, 0.8f);
  for (int c = 0; c < 3; ++c) EXPECT_NEAR(rgb.at(0, 0, c), stored[c], 1e-3f);
  for (const char* name : {"single", "single-full", "multi", "multi-full", "multi-rgb"})
    expect_same(std::string("12-exr-multipart-yc/") + name + ".exr", rgb, 1.0f, 1e-3f);
  expect_same("13-radiance-header/exposure.hdr", plain, 8.0f, 1e-4f);
  expect_same("13-radiance-header/down.hdr", load("13-radiance-header/up.hdr"), 1.0f, 0.0f);
  EXPECT_THROW(load("13-radiance-header/xyze.hdr"), Error);
}

}  // namespace
}  // namespace maquette
