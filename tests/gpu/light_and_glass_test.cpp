// Baked visibility, the scene's own lights and panes in whole frames, against closed forms.
#include <epoxy/gl.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "render/gl/context.h"
#include "render/math/shared_formulas.h"
#include "render/reference/reference.h"
#include "render/renderer.h"
#include "tests/support/path_scenes.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

using test::add;
using test::constant_sky;
using test::make_grid;

Material matte(const std::string& name, float albedo) {
  Material m;
  m.name = name;
  m.base_color = glm::vec4(albedo, albedo, albedo, 1.0f);
  m.metallic = 0.0f;
  m.roughness = 1.0f;
  m.specular = 0.0f;
  m.double_sided = true;
  return m;
}

Scene floor_scene() {
  Scene scene;
  scene.materials.push_back(matte("floor", 0.5f));
  add(&scene, make_grid({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 8, 0));
  return scene;
}

Scene box_scene(int walls) { return test::box_scene(walls, 6, matte("wall", 0.5f)); }

FrameRequest lit_request(const std::string& mode, const std::string& visibility) {
  FrameRequest r;
  r.mode = mode;
  r.width = 48;
  r.height = 48;
  r.samples = 64;
  r.settings.set_from_text("shading.visibility", visibility);
  r.settings.set_from_text("shading.indirect", "none");  // closed forms of direct light
  return r;
}

/// All tests draw by this function: no picture may contain NaN or cause a GL error.
Image draw_checked(Renderer* renderer, const FrameRequest& request) {
  EXPECT_TRUE(renderer->finish_background_work(request));
  renderer->render(request);
  const Image image = renderer->read_radiance();
  for (float v : image.data) EXPECT_TRUE(std::isfinite(v) && v >= 0.0f);
  const auto errors = take_gl_errors();
  EXPECT_TRUE(errors.empty()) << errors.front();
  return image;
}

/// A ray along the edge between two walls may hit or miss: a few samples in 10,000.
constexpr double kLeak = 5e-4;

double mean_radiance(const Image& image) {
  double sum = 0.0;
  for (std::size_t i = 0; i < image.data.size(); i += 4) sum += image.data[i];
  return sum / (static_cast<double>(image.data.size()) / 4.0);
}

class LightAndGlass : public ::testing::TestWithParam<std::string> {
 protected:
  GlContext context_ = GlContext::create_headless();
  void SetUp() override { install_debug_output(); }
};
INSTANTIATE_TEST_SUITE_P(Modes, LightAndGlass, ::testing::Values("uniform", "bandwidth"),
                         [](const auto& mode) { return mode.param; });

TEST_P(LightAndGlass, ClosedBoxIsBlackInsideAndOnlyWithVisibility) {
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>(box_scene(6)));
  renderer.set_environment(constant_sky(1.0f));
  FrameRequest request = lit_request(GetParam(), "baked");
  request.camera.eye = {0.3f, 0.2f, 0.8f};
  request.camera.target = {0.0f, 0.0f, -1.0f};
  EXPECT_LT(mean_radiance(draw_checked(&renderer, request)), kLeak);
  request.settings.set_from_text("shading.visibility", "none");
  EXPECT_NEAR(mean_radiance(draw_checked(&renderer, request)), 0.5, 0.02);
  request.settings.set_from_text("shading.visibility", "auto");  // it closes the eye in
  EXPECT_LT(mean_radiance(draw_checked(&renderer, request)), kLeak);
}

TEST_P(LightAndGlass, OpenPlaneIsTheSameWithVisibility) {
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>(floor_scene()));
  renderer.set_environment(constant_sky(2.0f));
  FrameRequest request = lit_request(GetParam(), "baked");
  request.camera.eye = {0.0f, 1.0f, 1.0f};
  request.camera.target = {0.0f, 0.0f, 0.0f};
  request.camera.fov_y_rad = 0.5f;
  const double baked = mean_radiance(draw_checked(&renderer, request));
  request.settings.set_from_text("shading.visibility", "none");
  EXPECT_NEAR(baked, 1.0, 0.02);
  EXPECT_NEAR(baked, mean_radiance(draw_checked(&renderer, request)), 0.02);
}

/// Under an open-topped box of height 2: the view factor of a 2 x 2 square from a point under its middle. The map's
/// cells are 0.22 rad wide and the opening 0.93, so 20 % is what it can tell. Source: Howell, "A Catalog of Radiation
/// Heat Transfer Configuration Factors", B-3 (a quarter, from its corner).
TEST_P(LightAndGlass, OpenTopLightsTheFloorByItsViewFactor) {
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>(box_scene(5)));
  renderer.set_environment(constant_sky(1.0f));
  FrameRequest request = lit_request(GetParam(), "baked");
  request.samples = 256;
  request.camera.eye = {0.0f, 0.9f, 0.0f};
  request.camera.target = {0.0f, -1.0f, 0.0f};
  request.camera.up = {0.0f, 0.0f, -1.0f};
  request.camera.fov_y_rad = 0.1f;
  const double x = 0.5;  // half side over distance
  const double root = std::sqrt(1.0 + x * x);
  const double corner = 2.0 / (2.0 * 3.14159265358979) * (x / root) * std::atan(x / root);
  EXPECT_NEAR(mean_radiance(draw_checked(&renderer, request)), 0.5 * 4.0 * corner, 0.2 * 0.5 * 4.0 * corner);
}

TEST_P(LightAndGlass, PictureIsDrawnWithoutTheBakeUntilItIsReady) {
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>(box_scene(6)));
  renderer.set_environment(constant_sky(1.0f));
  const FrameRequest request = lit_request(GetParam(), "baked");
  FrameStats stats = renderer.render(request);
  if (stats.plan.shading().visibility == "none") {  // the bake may have been quick
    const auto& out = stats.plan.left_out;
    EXPECT_TRUE(std::any_of(out.begin(), out.end(), [](const LeftOut& o) { return o.what == "visibility"; }));
  }
  ASSERT_TRUE(renderer.finish_background_work(request));
  EXPECT_TRUE(renderer.background_work().empty());
  stats = renderer.render(request);
  EXPECT_EQ(stats.plan.shading().visibility, "baked");
  EXPECT_GT(stats.gpu_bytes.at("visibility"), 0u);
}

TEST_P(LightAndGlass, EmptySceneHasNothingToBake) {
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>());
  renderer.set_environment(constant_sky(2.0f));
  EXPECT_NEAR(mean_radiance(draw_checked(&renderer, lit_request(GetParam(), "baked"))), 2.0, 0.01);
}

/// The roof is moved aside: the old bake is used until the new one is ready.
TEST_P(LightAndGlass, ChangedGeometryIsBakedAgain) {
  const auto scene = std::make_shared<Scene>(box_scene(6));
  Renderer renderer;
  renderer.set_scene(scene);
  renderer.set_environment(constant_sky(1.0f));
  FrameRequest request = lit_request(GetParam(), "baked");
  request.camera.eye = {0.0f, 0.9f, 0.0f};
  request.camera.target = {0.0f, -1.0f, 0.01f};
  EXPECT_LT(mean_radiance(draw_checked(&renderer, request)), kLeak);
  const Primitive& roof = scene->meshes[5].primitives[0];
  std::vector<glm::vec3> positions = roof.positions;
  for (glm::vec3& p : positions) p.x += 100.0f;
  renderer.update_mesh(5, positions, roof.normals);
  EXPECT_EQ(renderer.render(request).plan.shading().visibility, "baked");
  EXPECT_GT(mean_radiance(draw_checked(&renderer, request)), 0.05);
}

/// E = I cos / d^2 under a point light, and a spot light's axis; a directional light's lux.
TEST_P(LightAndGlass, PunctualLightsMeetTheClosedForm) {
  for (const auto kind : {PunctualLight::Kind::point, PunctualLight::Kind::spot, PunctualLight::Kind::directional}) {
    Scene scene = floor_scene();
    PunctualLight light;
    light.kind = kind;
    light.intensity = 10.0f;
    light.inner_cone_rad = 0.3f;
    scene.lights.push_back(light);
    Node node;
    node.light = 0;
    node.local[1] = glm::vec4(0.0f, 0.0f, -1.0f, 0.0f);  // -z of the node points down
    node.local[2] = glm::vec4(0.0f, 1.0f, 0.0f, 0.0f);
    node.local[3] = glm::vec4(0.0f, 2.0f, 0.0f, 1.0f);
    scene.roots.push_back(static_cast<int>(scene.nodes.size()));
    scene.nodes.push_back(node);
    Renderer renderer;
    renderer.set_scene(std::make_shared<Scene>(scene));
    renderer.set_environment(constant_sky(0.0f));
    FrameRequest request = lit_request(GetParam(), "none");
    request.env_scale = 7.0f;  // does not affect the scene's lights
    request.camera.eye = {0.0f, 3.0f, 0.0f};
    request.camera.target = {0.0f, 0.0f, 0.0f};
    request.camera.up = {0.0f, 0.0f, -1.0f};
    request.camera.fov_y_rad = 0.01f;
    const double lux = kind == PunctualLight::Kind::directional ? 10.0 : 10.0 / 4.0;
    EXPECT_NEAR(mean_radiance(draw_checked(&renderer, request)), 0.5 / 3.14159265 * lux, 0.004 * lux)
        << static_cast<int>(kind);
  }
}

/// An emissive square over the middle of the floor: E = L * 4 * view factor of a quarter * pi.
TEST_P(LightAndGlass, GlowingSquareMeetsTheClosedForm) {
  Scene scene = floor_scene();
  Material lamp = matte("lamp", 0.0f);
  lamp.emissive = glm::vec3(5.0f);
  lamp.double_sided = false;
  scene.materials.push_back(lamp);
  add(&scene, make_grid({-0.5f, 1.0f, -0.5f}, {1, 0, 0}, {0, 0, 1}, 3, 1));
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>(scene));
  renderer.set_environment(constant_sky(0.0f));
  FrameRequest request = lit_request(GetParam(), "none");
  request.samples = 256;
  request.camera.eye = {0.0f, 0.8f, 0.0f};
  request.camera.target = {0.0f, 0.0f, 0.0f};
  request.camera.up = {0.0f, 0.0f, -1.0f};
  request.camera.fov_y_rad = 0.05f;
  const double x = 0.5, root = std::sqrt(1.0 + x * x);
  const double quarter = 2.0 / (2.0 * 3.14159265358979) * (x / root) * std::atan(x / root);
  const double expected = 0.5 * 5.0 * 4.0 * quarter;
  EXPECT_NEAR(mean_radiance(draw_checked(&renderer, request)), expected, 0.02 * expected);
}

/// A lamp almost touching the floor: no sample may be larger than a few times the lamp's radiance.
TEST_P(LightAndGlass, LampCloseToASurfaceMakesNoFireflies) {
  Scene scene = floor_scene();
  Material lamp = matte("lamp", 0.0f);
  lamp.emissive = glm::vec3(5.0f);
  scene.materials.push_back(lamp);
  add(&scene, make_grid({-0.4f, 0.02f, -0.4f}, {0.4f, 0, 0}, {0, 0.4f, 0}, 1, 1));
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>(scene));
  renderer.set_environment(constant_sky(0.1f));
  FrameRequest request = lit_request(GetParam(), "none");
  request.camera.eye = {0.0f, 2.0f, 1.0f};
  request.camera.target = {0.0f, 0.0f, 0.0f};
  const Image image = draw_checked(&renderer, request);
  EXPECT_LE(*std::max_element(image.data.begin(), image.data.end()), 2.0f * 5.0f);
}

/// A dim strip of many triangles on the floor, a strong lamp far away: selected by power alone, the strip was sampled
/// once in a thousand samples, and was then a thousand times too bright.
TEST_P(LightAndGlass, DimLampsBesideASurfaceMakeNoFireflies) {
  Scene scene = floor_scene();
  Material glow = matte("strip", 0.0f);
  glow.emissive = glm::vec3(5.0f);
  scene.materials.push_back(glow);
  add(&scene, make_grid({-0.6f, 0.02f, 0.0f}, {1.2f, 0, 0}, {0, 0.01f, 0}, 24, 1));
  PunctualLight lamp;
  lamp.kind = PunctualLight::Kind::point;
  lamp.intensity = 100.0f;
  scene.lights.push_back(lamp);
  Node node;
  node.light = 0;
  node.local[3] = glm::vec4(0.0f, 12.0f, 0.0f, 1.0f);
  scene.roots.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(node);
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>(scene));
  renderer.set_environment(constant_sky(0.0f));
  FrameRequest request = lit_request(GetParam(), "none");
  request.camera.eye = {0.0f, 1.0f, 0.05f};
  request.camera.target = {0.0f, 0.0f, 0.0f};
  request.camera.fov_y_rad = 0.3f;
  const auto brightest = [](const Image& image) { return *std::max_element(image.data.begin(), image.data.end()); };
  const Image one = draw_checked(&renderer, request);
  request.mode = "uniform";
  request.samples = 4096;
  request.seed = 9;
  const Image converged = draw_checked(&renderer, request);
  EXPECT_LT(brightest(one), 2.0f * brightest(converged));
  EXPECT_NEAR(mean_radiance(one), mean_radiance(converged),
              0.1 * mean_radiance(converged));  // the foot of the strip is interpolated, too
}

/// At night a few light samples for 64 of the sky would give only noise.
TEST_P(LightAndGlass, LampsThatOutshineTheSkyHaveAsManySamples) {
  Scene scene = floor_scene();
  for (int k = 0; k < 8; ++k) {
    Material glow = matte("panel", 0.0f);
    glow.emissive = glm::vec3(10.0f * std::exp2(static_cast<float>(k % 4)));
    scene.materials.push_back(glow);
    add(&scene, make_grid({-0.8f + 0.2f * static_cast<float>(k), 0.3f, -0.5f}, {0.1f, 0, 0}, {0, 0, 0.8f}, 4,
                          static_cast<int>(scene.materials.size()) - 1));
  }
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>(scene));
  renderer.set_environment(constant_sky(1e-3f));
  FrameRequest request = lit_request(GetParam(), "none");
  request.camera.eye = {0.0f, 0.25f, 1.0f};
  request.camera.target = {0.0f, 0.0f, 0.0f};
  request.camera.fov_y_rad = 0.3f;
  const Image one = draw_checked(&renderer, request);
  request.seed = 5;
  const Image other = draw_checked(&renderer, request);
  double square = 0.0, sum = 0.0;
  for (std::size_t i = 0; i < one.data.size(); i += 4) {
    square += std::pow(static_cast<double>(one.data[i] - other.data[i]), 2.0);
    sum += static_cast<double>(one.data[i]);
  }
  EXPECT_LT(std::sqrt(0.5 * square * 48.0 * 48.0) / sum, GetParam() == "uniform" ? 0.1 : 0.03);
}

Scene pane_scene(const glm::vec4& tint) {
  Scene scene;
  Material glass = test::clear_pane();
  glass.name = "glass";
  glass.ior = 1.52f;
  glass.base_color = tint;
  glass.double_sided = true;
  scene.materials.push_back(glass);
  add(&scene, make_grid({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 2, 0));
  return scene;
}

/// Furnace: a clear pane removes as much light from behind as it adds by reflection.
TEST_P(LightAndGlass, ClearPaneVanishesInAConstantSky) {
  for (int msaa : {1, 4}) {
    Renderer renderer;
    renderer.set_scene(std::make_shared<Scene>(pane_scene(glm::vec4(1.0f))));
    renderer.set_environment(constant_sky(3.0f));
    FrameRequest request = lit_request(GetParam(), "none");
    request.msaa = msaa;
    request.camera.eye = {2.0f, 0.5f, 1.0f};
    const Image image = draw_checked(&renderer, request);
    for (std::size_t i = 0; i < image.data.size(); i += 4) {
      ASSERT_NEAR(image.data[i], 3.0f, 0.01f);
      ASSERT_EQ(image.data[i + 3], 0.0f);  // only the sky is seen
    }
  }
}

/// A pane above a black floor mirrors the whole sky upwards and nothing downwards: each face has its own visibility
/// map.
TEST_P(LightAndGlass, PaneMirrorsWhatItsFaceSees) {
  Scene scene = floor_scene();
  scene.materials[0] = matte("black", 0.0f);
  const Scene pane = pane_scene(glm::vec4(1.0f));
  scene.materials.push_back(pane.materials[0]);
  add(&scene, make_grid({-1, 0.05f, 1}, {2, 0, 0}, {0, 0, -2}, 8, 1));
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>(scene));
  renderer.set_environment(constant_sky(3.0f));
  const auto middle = [&](const std::string& visibility, float height_m, float target_m) {
    FrameRequest request = lit_request(GetParam(), visibility);
    request.camera.eye = {0.0f, height_m, 0.6f};
    request.camera.target = {0.0f, target_m, 0.0f};
    request.camera.fov_y_rad = 0.3f;
    return mean_radiance(draw_checked(&renderer, request));
  };
  const double above = middle("none", 0.25f, 0.05f), below = middle("none", 0.025f, 0.05f);
  EXPECT_GT(above, 0.2);
  EXPECT_NEAR(middle("baked", 0.25f, 0.05f), above, 0.01 * above);
  EXPECT_LT(middle("baked", 0.025f, 0.05f), 0.9 * below);
}

TEST_P(LightAndGlass, TintedPaneTransmitsAndReflectsByFresnel) {
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>(pane_scene(glm::vec4(0.8f, 1.0f, 0.5f, 1.0f))));
  renderer.set_environment(constant_sky(1.0f));
  FrameRequest request = lit_request(GetParam(), "none");
  request.camera.eye = {2.0f, 0.0f, 2.0f};
  request.camera.target = {0.0f, 0.0f, 0.0f};
  request.camera.fov_y_rad = 0.02f;
  const Image image = draw_checked(&renderer, request);
  const float cosine = std::sqrt(0.5f);
  for (int c : {0, 1, 2}) {
    const glm::vec2 pane = shared::fresnel_pane(cosine, 1.52f, c == 0 ? 0.8f : c == 1 ? 1.0f : 0.5f);
    EXPECT_NEAR(image.at(24, 24, c), pane.x + pane.y, 2e-3f);
  }
  // While the picture converges the pane is drawn once a frame, not over the frames before.
  renderer.render(request, true);
  renderer.render(request, true);
  EXPECT_NEAR(renderer.read_radiance().at(24, 24, 2), image.at(24, 24, 2), 2e-3f);
}

/// A dark glass sphere, whose near half covers the far one: its layers are drawn in the order of their distance,
/// whatever the order of its triangles. The reference uses rays.
TEST_P(LightAndGlass, PaneThatCoversItselfIsDrawnFromBackToFront) {
  const auto sky = test::sky_of(64, 32, [](const glm::dvec3& d) { return glm::dvec3(1.0 + 9.0 * (d.y > 0.0)); });
  Scene scene = test::sphere_of(pane_scene(glm::vec4(0.3f, 0.3f, 0.3f, 1.0f)).materials[0]);
  for (const bool reversed : {false, true}) {
    if (reversed) {
      std::vector<std::uint32_t>& indices = scene.meshes[0].primitives[0].indices;
      std::reverse(indices.begin(), indices.end());
      for (std::size_t i = 0; i + 2 < indices.size(); i += 3) std::swap(indices[i], indices[i + 1]);
    }
    FrameRequest request = lit_request(GetParam(), "none");
    request.camera.eye = {0.0f, 0.4f, 2.5f};
    Renderer renderer;
    renderer.set_scene(std::make_shared<Scene>(scene));
    renderer.set_environment(sky);
    const Image image = draw_checked(&renderer, request);
    PictureRequest traced;
    traced.camera = request.camera;
    traced.width = request.width;
    traced.height = request.height;
    traced.paths.transport = Transport::direct;
    ReferencePicture picture(build_path_scene({.scene = scene, .environment = sky}), traced);
    ASSERT_TRUE(picture.add(1));  // panes alone have no noise
    const Image reference = picture.mean();
    double difference = 0.0;
    for (std::size_t i = 0; i < image.data.size(); i += 4) difference += std::abs(image.data[i] - reference.data[i]);
    EXPECT_LT(difference / (48.0 * 48.0), 0.02) << (reversed ? "triangles in the reverse order" : "");
  }
}

TEST_P(LightAndGlass, PanesDoNotOccludeAndHaveDepth) {
  Scene scene = floor_scene();
  const Scene pane = pane_scene(glm::vec4(0.0f, 0.0f, 0.0f, 1.0f));
  scene.materials.push_back(pane.materials[0]);
  add(&scene, make_grid({-1, -0.5f, 1}, {2, 0, 0}, {0, 0, -2}, 2, 1));  // below the floor: not seen
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>(scene));
  renderer.set_environment(constant_sky(2.0f));
  FrameRequest request = lit_request(GetParam(), "baked");
  request.camera.eye = {0.0f, 1.0f, 0.5f};
  request.camera.target = {0.0f, 0.0f, 0.0f};
  request.camera.fov_y_rad = 0.3f;
  EXPECT_NEAR(mean_radiance(draw_checked(&renderer, request)), 1.0, 0.02);
}

TEST_P(LightAndGlass, BlendedSurfaceCoversByAlpha) {
  Scene scene;
  Material veil = matte("veil", 0.5f);
  veil.alpha_mode = AlphaMode::blend;
  veil.base_color.a = 0.25f;
  scene.materials.push_back(veil);
  add(&scene, make_grid({-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, 2, 0));
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>(scene));
  renderer.set_environment(constant_sky(4.0f));
  FrameRequest request = lit_request(GetParam(), "none");
  request.camera.eye = {0.0f, 0.0f, 1.0f};
  request.camera.target = {0.0f, 0.0f, 0.0f};
  EXPECT_NEAR(draw_checked(&renderer, request).at(24, 24, 1), 0.75f * 4.0f + 0.25f * 0.5f * 4.0f, 0.01f);
}

TEST_P(LightAndGlass, ResourcesAreReleased) {
  Scene scene = box_scene(5);
  scene.materials.push_back(pane_scene(glm::vec4(1.0f)).materials[0]);
  scene.materials[0].emissive = glm::vec3(0.1f);
  add(&scene, make_grid({-1, 1, -1}, {2, 0, 0}, {0, 0, 2}, 1, 1));
  const auto shared_scene = std::make_shared<Scene>(scene);
  const auto sky = constant_sky(1.0f);
  for (int round = 0; round < 20; ++round) {
    Renderer renderer;
    renderer.set_scene(shared_scene);
    renderer.set_environment(sky);
    FrameRequest request = lit_request(GetParam(), "baked");
    request.width = request.height = 8;
    if (round % 5 == 0) {
      draw_checked(&renderer, request);
    } else {
      renderer.render(request);  // destroyed while its bake runs
    }
  }
  int buffers = 0, textures = 0, framebuffers = 0, programs = 0, arrays = 0;
  for (GLuint name = 1; name < 20000; ++name) {
    buffers += glIsBuffer(name);
    textures += glIsTexture(name);
    framebuffers += glIsFramebuffer(name);
    programs += glIsProgram(name);
    arrays += glIsVertexArray(name);
  }
  EXPECT_EQ(buffers, 0);
  EXPECT_EQ(textures, 0);
  EXPECT_EQ(framebuffers, 0);
  EXPECT_LE(programs, 1);  // the driver keeps the one last in use
  EXPECT_EQ(arrays, 0);
  EXPECT_TRUE(take_gl_errors().empty());
}

}  // namespace
}  // namespace maquette
