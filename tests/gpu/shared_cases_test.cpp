// The small inputs of ../shared/data/cases, each with the value that its format's specification gives; skipped without.
#include <gtest/gtest.h>

#include <exception>
#include <filesystem>

#include "render/gl/context.h"
#include "render/renderer.h"
#include "scenes/environment.h"
#include "scenes/image_io.h"
#include "test_paths.h"

namespace maquette {
namespace {

const std::filesystem::path kCases = std::filesystem::path(MAQUETTE_SOURCE_DIR) / "../shared/data/cases";

struct Case {
  const char* file;
  bool black_sky;  ///< else of radiance 1
  glm::ivec2 pixel;
  glm::vec3 value;  ///< cd/m2; of a view: what it shows
  float tolerance;
  const char* view = "";
};

constexpr glm::ivec2 kMiddle{20, 20};
constexpr glm::vec3 kRed{1, 0, 0}, kGreen{0, 1, 0}, kBlue{0, 0, 1}, kOver{0.25f, 0.75f, 0.0f},
    kPlain{0.5f, 0.25f, 0.125f};
constexpr float kSlope = 0.70711f;

const Case kAll[] = {
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
    {"14-vertex-colour-precision/float-0.003.gltf", false, kMiddle, glm::vec3(0.003f), 0.00006f},
    {"14-vertex-colour-precision/short-0.003.gltf", false, kMiddle, glm::vec3(0.003f), 0.00006f},
    {"14-vertex-colour-precision/float-0.0055.gltf", false, kMiddle, glm::vec3(0.0055f), 0.00011f},
    {"14-vertex-colour-precision/short-0.0055.gltf", false, kMiddle, glm::vec3(0.0055f), 0.00011f},
    {"14-vertex-colour-precision/float-0.02.gltf", false, kMiddle, glm::vec3(0.02f), 0.0004f},
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

  glm::vec3 draw(const Case& c, const std::string& mode, const std::string& transport) {
    Renderer renderer;
    renderer.set_scene(std::make_shared<Scene>(load_scene((kCases / c.file).string())));
    auto sky = std::make_shared<Environment>();
    sky->name = "constant";
    sky->width = 32;
    sky->height = 16;
    sky->rgb.assign(32 * 16, glm::vec3(c.black_sky ? 0.0f : 1.0f));
    renderer.set_environment(sky);
    FrameRequest r;
    r.mode = mode;
    r.width = r.height = 40;
    r.samples = 256;
    r.camera.eye = {0.0f, 0.0f, 3.0f};
    r.camera.target = {0.0f, 0.0f, 0.0f};
    r.camera.fov_y_rad = 30.0f * 3.14159265f / 180.0f;
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
  for (const Case& c : kAll) {
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
      const float tolerance =
          c.tolerance * (looks_up ? 3.0f : 1.0f) + (std::string(transport) == "full" ? 0.02f : 0.0f);
      for (int k = 0; k < 3; ++k)
        EXPECT_NEAR(value[k], c.value[k], tolerance)
            << c.file << " in " << mode << " " << transport << ", channel " << k;
    }
  }
}

}  // namespace
}  // namespace maquette
