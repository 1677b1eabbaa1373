#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <memory>
#include <numbers>
#include <string>

#include "render/gl/context.h"
#include "render/materials/brdf_tables.h"
#include "render/renderer.h"
#include "tests/support/test_scenes.h"

// Modes splitsum and sg against closed forms and against mode uniform.
namespace {

using namespace maquette;
using test::constant_sky;
using test::white_lambert;

constexpr int kSize = 64;

std::shared_ptr<Environment> make_sky(int width, const std::function<glm::dvec3(const glm::dvec3&)>& radiance) {
  auto sky = std::make_shared<Environment>();
  sky->width = width;
  sky->height = width / 2;
  for (int y = 0; y < sky->height; ++y)
    for (int x = 0; x < width; ++x)
      sky->rgb.emplace_back(radiance(direction_from_latlong(x + 0.5, y + 0.5, width, sky->height)));
  return sky;
}

glm::dvec3 smooth_radiance(const glm::dvec3& d) { return {1.0 + 0.8 * d.y, 1.0 + 0.5 * d.x * d.z, 1.0 - 0.6 * d.x}; }

std::shared_ptr<Scene> sphere_of(const Material& material) {
  return std::make_shared<Scene>(test::sphere_of(material));
}

FrameRequest sphere_request(const Scene& scene, const std::string& mode) {
  FrameRequest request;
  request.mode = mode;
  request.width = request.height = kSize;
  const auto world = compute_world_transforms(scene);
  for (std::size_t n = 0; n < scene.nodes.size(); ++n) {
    if (scene.nodes[n].camera < 0) continue;
    request.camera.eye = glm::vec3(world[n][3]);
    request.camera.target = request.camera.eye - glm::vec3(world[n][2]);
    request.camera.up = glm::vec3(world[n][1]);
    request.camera.fov_y_rad = scene.cameras[static_cast<std::size_t>(scene.nodes[n].camera)].fov_y_rad;
    break;
  }
  return request;
}

Image converged(Renderer& renderer, FrameRequest request) {
  request.mode = "uniform";
  request.samples = 512;
  for (int i = 0; i < 4; ++i) renderer.render(request, true);
  return renderer.read_radiance();
}

/// Relative root mean square over the channels of covered pixels.
double relative_error(const Image& image, const Image& truth) {
  double squares = 0.0, sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < truth.data.size(); i += 4) {
    if (truth.data[i + 3] < 1.0f) continue;
    for (std::size_t c = 0; c < 3; ++c) {
      const double difference = static_cast<double>(image.data[i + c]) - static_cast<double>(truth.data[i + c]);
      squares += difference * difference;
      sum += static_cast<double>(truth.data[i + c]);
      ++count;
    }
  }
  EXPECT_GT(count, 1000u);
  return std::sqrt(squares / static_cast<double>(count)) / (sum / static_cast<double>(count));
}

class LookupModes : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override { install_debug_output(); }
  void TearDown() override { EXPECT_EQ(take_gl_errors(), std::vector<std::string>{}); }
  GlContext context_ = GlContext::create_headless();
};

TEST_P(LookupModes, WhiteLambertShowsAConstantSky) {
  Renderer renderer;
  const auto scene = sphere_of(white_lambert());
  renderer.set_scene(scene);
  renderer.set_environment(constant_sky(0.75f));
  FrameRequest request = sphere_request(*scene, GetParam());
  request.env_scale = 2.0f;
  renderer.render(request);
  const Image image = renderer.read_radiance();
  int covered = 0;
  for (std::size_t i = 0; i < image.data.size(); i += 4) {
    covered += image.data[i + 3] >= 1.0f;
    for (std::size_t c = 0; c < 3; ++c) ASSERT_NEAR(image.data[i + c], 1.5f, 2e-3f) << i;  // sphere and sky alike
  }
  EXPECT_GT(covered, 1000);
}

TEST_P(LookupModes, MeasuredTableShowsItsAlbedoUnderAConstantSky) {
  const char* source = "builtin:paint-silver-metallic";
  const BrdfTables tables = load_brdf_tables(load_brdf(source));
  Renderer renderer;
  Material material;
  material.measured = source;
  const auto scene = sphere_of(material);
  renderer.set_scene(scene);
  renderer.set_environment(constant_sky(1.0f));
  renderer.render(sphere_request(*scene, GetParam()));
  const Image image = renderer.read_radiance();
  // Two reflectances cannot match every measured material at all elevations; sg has a factor for each elevation.
  const float tolerance = std::string(GetParam()) == "sg" ? 0.04f : 0.15f;
  for (int c = 0; c < 3; ++c) {
    const float albedo = tables.albedo[0][c];
    EXPECT_NEAR(image.at(kSize / 2, kSize / 2, c), albedo, tolerance * albedo) << c;
  }
}

TEST_P(LookupModes, GgxUnderASmoothSkyAgreesWithUniform) {
  Renderer renderer;
  for (const float roughness : {0.25f, 0.5f}) {
    Material material;
    material.base_color = glm::vec4(0.9f, 0.6f, 0.3f, 1.0f);
    material.roughness = roughness;
    const auto scene = sphere_of(material);
    renderer.set_scene(scene);
    renderer.set_environment(make_sky(64, smooth_radiance));
    const FrameRequest request = sphere_request(*scene, GetParam());
    const Image truth = converged(renderer, request);
    renderer.render(request);
    EXPECT_LT(relative_error(renderer.read_radiance(), truth), 0.04) << roughness;
  }
}

TEST_P(LookupModes, CoatAndSheenAgreeWithUniform) {
  Renderer renderer;
  for (const bool coated : {false, true}) {
    Material material;
    material.base_color = glm::vec4(0.6f, 0.2f, 0.1f, 1.0f);
    material.metallic = 0.0f;
    material.roughness = 0.6f;
    if (coated) {
      material.clearcoat = 1.0f;
      material.clearcoat_roughness = 0.3f;
    } else {
      material.sheen_color = glm::vec3(0.5f);
      material.sheen_roughness = 0.5f;
    }
    const auto scene = sphere_of(material);
    renderer.set_scene(scene);
    renderer.set_environment(make_sky(64, smooth_radiance));
    const FrameRequest request = sphere_request(*scene, GetParam());
    const Image truth = converged(renderer, request);
    renderer.render(request);
    EXPECT_LT(relative_error(renderer.read_radiance(), truth), 0.06) << coated;
  }
}

// Above the horizon the sky is green, below it red. A smooth coat over black shows 4 % of what it mirrors: tilted up by
// 30 degrees the green, down the red; over a base that is tilted, and not its own, half of each.
TEST_P(LookupModes, CoatMirrorsAroundItsOwnNormal) {
  const auto tilted = [](Scene* scene, float degrees) {
    const float angle = degrees * std::numbers::pi_v<float> / 180.0f;
    const auto byte = [](float v) { return static_cast<std::uint8_t>(127.5f + 127.5f * v + 0.5f); };
    TextureImage image;
    image.width = image.height = 1;
    image.rgba = {byte(0.0f), byte(std::sin(angle)), byte(std::cos(angle)), 255};
    TextureRef ref;
    ref.image = static_cast<int>(scene->images.size());
    scene->images.push_back(image);
    return ref;
  };
  Scene scene;
  for (int k = 0; k < 3; ++k) {
    Material m;
    m.base_color = glm::vec4(0, 0, 0, 1);
    m.metallic = m.specular = 0.0f;
    m.roughness = m.clearcoat = 1.0f;
    m.clearcoat_roughness = 0.1f;
    if (k < 2)
      m.clearcoat_normal_texture = tilted(&scene, k == 0 ? 30.0f : -30.0f);
    else
      m.normal_texture = tilted(&scene, 30.0f);
    scene.materials.push_back(m);
    Primitive quad = test::make_grid({static_cast<float>(k) - 1.5f, -0.5f, 0}, {1, 0, 0}, {0, 1, 0}, 1, k);
    quad.uvs[0] = {{0, 1}, {1, 1}, {0, 0}, {1, 0}};
    quad.tangents.assign(4, glm::vec4(1, 0, 0, 1));
    test::add(&scene, std::move(quad));
  }
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>(scene));
  renderer.set_environment(make_sky(64, [](const glm::dvec3& d) { return glm::dvec3(d.y<0.0, d.y> 0.0, 0.0); }));
  FrameRequest request;
  request.mode = GetParam();
  request.width = 48;
  request.height = 16;
  request.camera.eye = glm::vec3(0, 0, 3);
  request.camera.target = glm::vec3(0.0f);
  request.camera.height_m = 1.0f;
  request.settings.set("shading.visibility", std::string("none"));
  renderer.render(request);
  const Image image = renderer.read_radiance();
  const glm::dvec3 expected[] = {{0.0, 0.04, 0.0}, {0.04, 0.0, 0.0}, {0.02, 0.02, 0.0}};
  for (int k = 0; k < 3; ++k)
    for (int c = 0; c < 3; ++c)
      EXPECT_NEAR(image.at(16 * k + 8, 8, c), expected[k][c], 0.002) << k << ", channel " << c;
}

TEST_P(LookupModes, RotatingTheEnvironmentIsRotatingTheMap) {
  const auto spotted = [](const glm::dvec3& d) {
    const double spot = 20.0 * std::exp(60.0 * (glm::dot(d, glm::normalize(glm::dvec3(0.3, 0.5, 0.8))) - 1.0));
    return smooth_radiance(d) + glm::dvec3(spot, 0.5 * spot, 0.1 * spot);
  };
  const auto sky = make_sky(64, spotted);
  auto rotated = std::make_shared<Environment>(*sky);
  for (int y = 0; y < sky->height; ++y)
    for (int x = 0; x < sky->width; ++x) {
      // From +Z towards +X: to the left by a quarter of the map.
      rotated->rgb[static_cast<std::size_t>(y * 64 + x)] = sky->rgb[static_cast<std::size_t>(y * 64 + (x + 16) % 64)];
    }
  Renderer renderer;
  Material material;
  material.roughness = 0.35f;
  const auto scene = sphere_of(material);
  renderer.set_scene(scene);
  FrameRequest request = sphere_request(*scene, GetParam());
  renderer.set_environment(sky);
  renderer.render(request);
  const Image still = renderer.read_radiance();
  request.env_rotation_rad = std::numbers::pi_v<float> / 2.0f;
  renderer.render(request);
  const Image by_rotation = renderer.read_radiance();
  request.env_rotation_rad = 0.0f;
  renderer.set_environment(rotated);
  renderer.render(request);
  EXPECT_LT(relative_error(renderer.read_radiance(), by_rotation), 0.01);
  EXPECT_GT(relative_error(still, by_rotation), 0.1);
}

TEST_P(LookupModes, HardSkiesStayFinite) {
  Renderer renderer;
  Material material;
  material.measured = "builtin:metal-chrome";
  const auto scene = sphere_of(material);
  renderer.set_scene(scene);
  for (int kind = 0; kind < 3; ++kind) {
    auto sky = constant_sky(0.0f);
    if (kind == 1) sky->rgb[40] = glm::vec3(1e7f);
    if (kind == 2) *sky = *make_sky(2, [](const glm::dvec3&) { return glm::dvec3(1.0); });
    renderer.set_environment(sky);
    renderer.render(sphere_request(*scene, GetParam()));
    float largest = 0.0f;
    const Image image = renderer.read_radiance();
    for (std::size_t i = 0; i < image.data.size(); ++i) {
      ASSERT_TRUE(std::isfinite(image.data[i]) && image.data[i] >= 0.0f) << kind;
      if (i % 4 != 3) largest = std::max(largest, image.data[i]);
    }
    EXPECT_EQ(largest > 0.0f, kind != 0) << kind;
  }
}

TEST_P(LookupModes, ResourcesExistOnlyOnceUsed) {
  Renderer renderer;
  const auto scene = sphere_of(white_lambert());
  renderer.set_scene(scene);
  renderer.set_environment(constant_sky(1.0f));
  FrameRequest request = sphere_request(*scene, "uniform");
  request.samples = 4;
  const FrameStats before = renderer.render(request);
  EXPECT_EQ(before.gpu_bytes.count("prefilter"), 0u);
  request.mode = GetParam();
  const FrameStats after = renderer.render(request);
  EXPECT_GT(after.gpu_bytes.at("prefilter"), 0u);
  EXPECT_EQ(after.visible_pixels, before.visible_pixels);
  EXPECT_EQ(after.shaded_pixels, before.shaded_pixels);
  EXPECT_EQ(after.shading_samples, 0u);
  for (const char* name : {"prefilter", "shade"})
    EXPECT_TRUE(std::any_of(after.passes.begin(), after.passes.end(), [&](const PassTime& p) {
      return p.name == name;
    })) << name;
}

TEST_P(LookupModes, TablesAreKeptWhileAnotherModeDrawsOrTheSizeChanges) {
  Renderer renderer;
  const auto scene = sphere_of(white_lambert());
  renderer.set_scene(scene);
  renderer.set_environment(make_sky(32, smooth_radiance));
  FrameRequest request = sphere_request(*scene, GetParam());
  const auto filters = [](const FrameStats& stats) {
    return std::ranges::any_of(stats.passes, [](const PassTime& pass) { return pass.name == "prefilter"; });
  };
  EXPECT_TRUE(filters(renderer.render(request)));
  const Image first = renderer.read_radiance();
  request.mode = "uniform";
  EXPECT_FALSE(filters(renderer.render(request)));
  request.mode = GetParam();
  request.width = request.height = kSize / 2;
  const FrameStats small = renderer.render(request);
  EXPECT_FALSE(filters(small));
  EXPECT_GT(small.gpu_bytes.at("prefilter"), 0u);
  renderer.forget_frames();
  request.width = request.height = kSize;
  EXPECT_FALSE(filters(renderer.render(request)));
  EXPECT_EQ(renderer.read_radiance().data, first.data) << "the same picture";
  renderer.set_environment(make_sky(32, [](const glm::dvec3& d) { return 2.0 * smooth_radiance(d); }));
  EXPECT_TRUE(filters(renderer.render(request))) << "another light needs others";
}

INSTANTIATE_TEST_SUITE_P(Modes, LookupModes, testing::Values("splitsum", "sg"),
                         [](const auto& mode) { return std::string(mode.param); });

}  // namespace
