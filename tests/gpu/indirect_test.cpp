// Baked indirect light on the GPU against the path tracer, and scenes whose scale leaves the range of half floats.
#include <gtest/gtest.h>

#include <cmath>

#include "render/gl/context.h"
#include "render/reference/reference.h"
#include "render/renderer.h"
#include "tests/support/path_scenes.h"
#include "tests/support/test_scenes.h"
#include "tests/support/waiting.h"

namespace {

using namespace maquette;

class Indirect : public ::testing::TestWithParam<std::string> {
 protected:
  GlContext context_ = GlContext::create_headless();
  void SetUp() override { install_debug_output(); }
};
INSTANTIATE_TEST_SUITE_P(Modes, Indirect, ::testing::Values("uniform", "bandwidth"),
                         [](const auto& mode) { return mode.param; });

/// A room, open above, two metres deep; one wall red. Grids, because light is baked at vertices.
Scene room() {
  Scene scene = test::box_scene(5, 16, test::matte(glm::vec3(0.7f)));
  scene.materials.push_back(test::matte(glm::vec3(0.8f, 0.1f, 0.1f)));
  scene.meshes[2].primitives[0].material = 1;
  return scene;
}

/// From above onto the floor, with baked shadows.
FrameRequest into_room(const std::string& mode, int side, int samples) {
  FrameRequest request;
  request.mode = mode;
  request.width = request.height = side;
  request.samples = samples;
  request.camera = {.eye = {0.3f, 0.9f, 0.2f}, .target = {0.0f, -1.0f, 0.0f}, .up = {0, 0, -1}, .fov_y_rad = 1.0f};
  request.settings.set_from_text("shading.visibility", "baked");
  return request;
}

glm::dvec3 mean(const Image& image) {
  glm::dvec3 sum(0.0);
  for (int y = 0; y < image.height; ++y)
    for (int x = 0; x < image.width; ++x)
      for (int c = 0; c < 3; ++c) sum[c] += static_cast<double>(image.at(x, y, c));
  return sum / (static_cast<double>(image.width) * image.height);
}

TEST_P(Indirect, RoomIsAsBrightAsThePathTracerSays) {
  const auto scene = std::make_shared<Scene>(room());
  const auto sky =
      test::sky_of(64, 32, [](const glm::dvec3& d) { return glm::dvec3(1.0, 1.0, 1.2) * (1.0 + 0.7 * d.x); });
  Renderer renderer;
  renderer.set_scene(scene);
  renderer.set_environment(sky);
  FrameRequest request = into_room(GetParam(), 40, 128);
  request.env_rotation_rad = 0.6f;
  const auto draw = [&](const char* indirect) {
    request.settings.set_from_text("shading.indirect", indirect);
    EXPECT_TRUE(renderer.finish_background_work(request));
    const FrameStats stats = renderer.render(request);
    EXPECT_EQ(stats.plan.shading().indirect, indirect);
    if (std::string(indirect) == "baked") {
      EXPECT_EQ(stats.gpu_bytes.at("indirect"), 5u * 17u * 17u * 16u);
    }
    EXPECT_TRUE(take_gl_errors().empty());
    return mean(renderer.read_radiance());
  };
  const glm::dvec3 without = draw("none"), with = draw("baked");
  PictureRequest traced;
  traced.camera = request.camera;
  traced.width = traced.height = 40;
  traced.paths.env_rotation_rad = request.env_rotation_rad;
  ReferencePicture picture(build_path_scene({.scene = *scene, .environment = sky}), traced);
  picture.add(256);
  const glm::dvec3 truth = mean(picture.mean());
  for (int c = 0; c < 3; ++c) {
    EXPECT_LT(without[c], 0.85 * truth[c]) << c;
    EXPECT_NEAR(with[c] / truth[c], 1.0, 0.07) << c;
  }
}

/// A mirror in place of the wall that the camera looks at.
/// Shadows of the sky wait for it: points that were shaded before are not of the picture that it belongs to.
TEST_P(Indirect, ItsShadowsRenewWhatWasShadedBefore) {
  const auto scene = std::make_shared<Scene>(room());
  const auto sky = test::constant_sky(1.0f);
  const FrameRequest request = into_room(GetParam(), 48, 64);
  constexpr int kMore = 4;
  Renderer waits, ready;
  for (Renderer* r : {&waits, &ready}) {
    r->set_scene(scene);
    r->set_environment(sky);
  }
  FrameStats stats = waits.render(request, true);
  EXPECT_EQ(stats.plan.shading().visibility, "none");
  ASSERT_TRUE(test::comes_true([&] {
    stats = waits.render(request, true);
    // A first result comes before the whole one, and each begins the picture anew.
    return stats.plan.shading().indirect == "baked" && stats.status.indirect.state == BakeState::ready;
  }));
  for (int frame = 0; frame < kMore; ++frame) stats = waits.render(request, true);
  EXPECT_TRUE(ready.finish_background_work(request));
  while (ready.render(request, true).status.accumulated < stats.status.accumulated) continue;
  const Image picture = waits.read_radiance(), expected = ready.read_radiance();
  double squares = 0.0, light = 0.0;
  for (std::size_t i = 0; i < picture.data.size(); ++i) {
    if (i % 4 == 3) continue;
    squares += std::pow(static_cast<double>(picture.data[i] - expected.data[i]), 2.0);
    light += static_cast<double>(expected.data[i]);
  }
  const double count = 0.75 * static_cast<double>(picture.data.size());
  EXPECT_LT(std::sqrt(squares / count) / (light / count), 0.02);
}

TEST_P(Indirect, AMirrorShowsTheLightOfTheRoom) {
  Scene scene = room();
  Material metal;
  metal.base_color = glm::vec4(0.95f, 0.95f, 0.95f, 1.0f);
  metal.metallic = 1.0f;
  metal.roughness = 0.01f;
  scene.materials.push_back(metal);
  BezierPatch patch;
  patch.material = 2;
  for (std::size_t i = 0; i < 16; ++i)
    patch.points[i] = {2.0f * static_cast<float>(i % 4) / 3.0f - 1.0f, 2.0f * static_cast<float>(i / 4) / 3.0f - 1.0f,
                       -0.9f};
  Node node;
  node.patch = 0;
  scene.patches.push_back(patch);
  scene.roots.push_back(static_cast<int>(scene.nodes.size()));
  scene.nodes.push_back(node);
  const auto sky = test::sky_of(64, 32, [](const glm::dvec3& d) { return glm::dvec3(1.0, 1.0, 1.2) * (1.0 + d.y); });
  Renderer renderer;
  renderer.set_scene(std::make_shared<Scene>(scene));
  renderer.set_environment(sky);
  FrameRequest request;
  request.mode = GetParam();
  request.reflections = "raytraced";
  request.width = request.height = 40;
  request.samples = 64;
  request.camera = {.eye = {0.2f, -0.2f, 0.8f}, .target = {0.0f, -0.3f, -0.9f}, .fov_y_rad = 0.5f};
  request.settings.set_from_text("shading.visibility", "baked");
  request.settings.set_from_text("reflections.resolution", "full");
  request.settings.set_from_text("reflections.samples", "256");
  const auto draw = [&](const char* indirect) {
    request.settings.set_from_text("shading.indirect", indirect);
    EXPECT_TRUE(renderer.finish_background_work(request));
    renderer.render(request);
    EXPECT_TRUE(take_gl_errors().empty());
    return mean(renderer.read_radiance());
  };
  const glm::dvec3 without = draw("none"), with = draw("baked");
  PictureRequest traced;
  traced.camera = request.camera;
  traced.width = traced.height = 40;
  ReferencePicture picture(build_path_scene({.scene = scene, .environment = sky}), traced);
  picture.add(256);
  const glm::dvec3 truth = mean(picture.mean());
  for (int c = 0; c < 3; ++c) {
    EXPECT_LT(without[c], 0.85 * truth[c]) << c;
    EXPECT_NEAR(with[c] / truth[c], 1.0, 0.07) << c;
  }
}

/// While the environment rotates the picture is interpolated between bakes for an earlier and a later rotation; at rest
/// it is the picture for the final rotation.
TEST_P(Indirect, ALightThatTurnsIsFollowed) {
  const auto scene = std::make_shared<Scene>(room());
  const auto sky = test::sky_of(128, 64, [](const glm::dvec3& d) {
    return glm::dvec3(1.0 + 40.0 * std::pow(std::max(d.x * 0.8 + d.y * 0.6, 0.0), 16.0));
  });
  FrameRequest request = into_room(GetParam(), 32, 64);
  request.settings.set("shading.reuse", false);
  constexpr float kTurn_rad = 1.2f, kStep_rad = 0.02f;
  constexpr int kFramesOfABake = 8;
  const auto at_rest_at = [&](float rotation_rad, float shown_rad) {
    Renderer renderer;
    renderer.set_scene(scene);
    renderer.set_environment(sky);
    request.env_rotation_rad = rotation_rad;
    EXPECT_TRUE(renderer.finish_background_work(request));
    request.env_rotation_rad = shown_rad;
    renderer.render(request);
    return renderer.read_radiance();
  };
  const Image truth = at_rest_at(kTurn_rad, kTurn_rad), stale = at_rest_at(0.0f, kTurn_rad);
  Renderer renderer;
  renderer.set_scene(scene);
  renderer.set_environment(sky);
  request.env_rotation_rad = 0.0f;
  EXPECT_TRUE(renderer.finish_background_work(request));
  const int frames = static_cast<int>(std::lround(kTurn_rad / kStep_rad));
  for (int f = 1; f <= frames; ++f) {
    request.env_rotation_rad = f == frames ? kTurn_rad : kStep_rad * static_cast<float>(f);
    renderer.render(request);
    // A bake takes some frames, whatever the machine.
    EXPECT_TRUE(f % kFramesOfABake != 0 || f == frames || renderer.finish_background_work(request));
  }
  const auto difference = [&](const Image& a) {
    double sum = 0.0;
    for (std::size_t i = 0; i < a.data.size(); ++i) sum += std::abs(static_cast<double>(a.data[i] - truth.data[i]));
    return sum;
  };
  const double followed = difference(renderer.read_radiance());
  RecordProperty("share of a stale bake's error", std::to_string(followed / difference(stale)));
  EXPECT_LT(followed, 0.5 * difference(stale));
  EXPECT_FALSE(renderer.background_work().empty());
  EXPECT_TRUE(renderer.finish_background_work(request));
  EXPECT_TRUE(renderer.background_work().empty());
  renderer.render(request);
  EXPECT_EQ(renderer.read_radiance().data, truth.data);
}

/// Textures vary at 1e8 cycles per metre in a scene of a micrometre: the G-buffer's channels must hold that.
TEST_P(Indirect, ScaleLeavesThePictureAsItIs) {
  const auto picture = [&](float scale) {
    Scene scene = load_scene("builtin:plate");
    for (const int root : scene.roots) {
      glm::mat4 grow(scale);
      grow[3][3] = 1.0f;
      scene.nodes[static_cast<std::size_t>(root)].local = grow * scene.nodes[static_cast<std::size_t>(root)].local;
    }
    Renderer renderer;
    renderer.set_scene(std::make_shared<Scene>(std::move(scene)));
    renderer.set_environment(test::sky_of(64, 32, [](const glm::dvec3& d) { return glm::dvec3(1.2 + d.y); }));
    FrameRequest request;
    request.mode = GetParam();
    request.width = 64;
    request.height = 40;
    request.samples = 32;
    request.camera = {.eye = glm::vec3(0.5f, 1.5f, 4.0f) * scale, .target = glm::vec3(0.0f, 0.3f, 0.0f) * scale};
    request.settings.set_from_text("shading.visibility", "none");
    renderer.render(request);
    EXPECT_TRUE(take_gl_errors().empty());
    return renderer.read_radiance();
  };
  const Image one = picture(1.0f);
  for (const float scale : {1e-6f, 1e6f}) {
    const Image other = picture(scale);
    double difference = 0.0, sum = 0.0;
    for (std::size_t i = 0; i < one.data.size(); ++i) {
      ASSERT_TRUE(std::isfinite(other.data[i])) << scale;
      difference += std::abs(static_cast<double>(other.data[i] - one.data[i]));
      sum += static_cast<double>(one.data[i]);
    }
    EXPECT_LT(difference, 0.02 * sum) << scale;
  }
}

}  // namespace
