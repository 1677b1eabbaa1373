// The section plane in every way of drawing, against rays and plates in closed form.
#include <gtest/gtest.h>

#include <optional>
#include <random>

#include "render/gl/context.h"
#include "render/renderer.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

constexpr int kSectionSide = 48;
constexpr float kPane_z = 1.0f, kRed_z = 0.0f, kGreen_z = -1.5f;  // z of the plates, m
constexpr float kHalf = 1.2f;

class SectionPlane : public ::testing::Test {
 protected:
  SectionPlane() {
    Scene scene;
    scene.materials = {glowing({1, 0, 0}), glowing({0, 1, 0}), Material()};
    scene.materials[2].glass = true;
    scene.materials[2].metallic = scene.materials[2].roughness = 0.0f;
    scene.materials[2].double_sided = true;
    for (const auto& [z, material] : {std::pair(kRed_z, 0), {kGreen_z, 1}, {kPane_z, 2}})
      test::add(&scene, test::make_grid({-kHalf, -kHalf, z}, {2 * kHalf, 0, 0}, {0, 2 * kHalf, 0}, 1, material));
    renderer_.set_scene(std::make_shared<Scene>(scene));
    renderer_.set_environment(test::constant_sky(0.0f));
  }
  static Material glowing(const glm::vec3& color) {
    Material m = test::matte(glm::vec3(0.0f));
    m.emissive = color;
    m.double_sided = true;
    return m;
  }
  Image draw(const std::string& mode, const glm::vec4& section, float height_m) {
    FrameRequest r;
    r.mode = mode;
    r.width = r.height = kSectionSide;
    paths_ = mode == "reference";  // through all of a pixel, and by chance through the pane or off it
    r.samples = paths_ ? 64 : 4;
    r.camera.eye = {0.3f, 0.2f, 4.0f};
    r.camera.target = {0.0f, 0.0f, -0.5f};
    r.camera.height_m = height_m;
    r.camera.section = section;
    camera_ = make_camera_frame(r.camera, kSectionSide, kSectionSide, bounds_of_plates());
    renderer_.finish_background_work(r);
    renderer_.render(r);
    const auto errors = take_gl_errors();
    EXPECT_TRUE(errors.empty()) << errors.front();
    return renderer_.read_radiance();
  }
  static Bounds bounds_of_plates() { return {{-kHalf, -kHalf, kGreen_z}, {kHalf, kHalf, kPane_z}}; }
  /// Whether a ray through a pixel shows the plate; nothing near a border.
  std::optional<bool> shows(int x, int y, float z, const glm::vec4& section) const {
    const EyeRay ray = camera_.ray_through({2.0f * (static_cast<float>(x) + 0.5f) / kSectionSide - 1.0f,
                                            1.0f - 2.0f * (static_cast<float>(y) + 0.5f) / kSectionSide});
    const glm::vec3 p = ray.origin + ray.direction * ((z - ray.origin.z) / ray.direction.z);
    const float margin = paths_ ? 0.08f : 0.01f, inside = kHalf - std::max(std::abs(p.x), std::abs(p.y)),
                kept = section.w - glm::dot(glm::vec3(section), p);
    if (std::abs(inside) < margin || (std::abs(kept) < margin && section != glm::vec4(0.0f))) return std::nullopt;
    return inside > 0.0f && kept >= 0.0f;
  }
  void expect_plates(const Image& image, const glm::vec4& section, const std::string& what) {
    int seen = 0, wrong = 0, behind = 0;
    double through = 0.0;
    for (int y = 0; y < kSectionSide; ++y)
      for (int x = 0; x < kSectionSide; ++x) {
        const auto pane = shows(x, y, kPane_z, section), red = shows(x, y, kRed_z, section),
                   green = shows(x, y, kGreen_z, section);
        if (!pane || !red || !green) continue;
        ++seen;
        const float r = image.at(x, y, 0), g = image.at(x, y, 1);
        const float value = *red ? r : g, other = *red ? g : r;
        const bool light = *red || *green;
        const bool good = other < 1e-3f && (!light  ? value < 1e-3f
                                            : *pane ? value > (paths_ ? 0.6f : 0.75f) && (paths_ || value < 0.98f)
                                                    : std::abs(value - 1.0f) < 1e-3f);
        wrong += good ? 0 : 1;
        if (*pane && light) through += static_cast<double>(value), ++behind;
      }
    EXPECT_EQ(wrong, 0) << what << ": of " << seen << " pixels";
    EXPECT_GT(seen, kSectionSide * kSectionSide / 3);
    if (behind > 100) {
      EXPECT_NEAR(through / behind, 0.92, 0.05) << what << ": the pane transmits";
    }
  }

  GlContext context_ = GlContext::create_headless();
  Renderer renderer_;
  CameraFrame camera_;
  bool paths_ = false;
};

TEST_F(SectionPlane, CutsWhatTheEyeSeesInEveryMode) {
  std::mt19937 random(36);
  const auto real = [&] { return std::uniform_real_distribution<float>(-1.0f, 1.0f)(random); };
  for (const char* mode : {"uniform", "bandwidth", "splitsum", "sg", "reference"})
    for (int round = 0; round < 8; ++round) {
      const glm::vec3 normal = glm::normalize(glm::vec3(real(), real(), real()));
      const glm::vec4 section(normal, 0.7f * real());
      const float height_m = round % 4 == 3 ? 2.6f : 0.0f;
      const Image image = draw(mode, section, height_m);
      expect_plates(image, section, std::string(mode) + ", round " + std::to_string(round));
    }
}

TEST_F(SectionPlane, AnEyeThatIsCutAwaySeesBehindThePlane) {
  for (const char* mode : {"uniform", "reference"}) {
    const glm::vec4 before(0.0f, 0.0f, 1.0f, 0.5f), behind(0.0f, 0.0f, 1.0f, -0.5f), none(0.0f);
    expect_plates(draw(mode, before, 0.0f), before, "the pane is cut away");
    expect_plates(draw(mode, behind, 0.0f), behind, "red too");
    expect_plates(draw(mode, none, 0.0f), none, "nothing is");
  }
}

}  // namespace
}  // namespace maquette
