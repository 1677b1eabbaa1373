#include "viewer/session.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "render/parts/parts.h"
#include "render/technique/registry.h"
#include "scenes/error.h"
#include "scenes/ground.h"
#include "tests/support/test_scenes.h"
#include "viewer/dents.h"
#include "viewer/pose.h"

namespace maquette {
namespace {

template <typename Call>
std::string usage_error(const Call& call) {
  try {
    call();
  } catch (const UsageError& error) {
    return error.what();
  }
  ADD_FAILURE() << "no usage error";
  return {};
}

/// One triangle in the plane z = 0, a camera at (0, 0, 5) named `front` and one below it named after its node, `low`.
Scene make_scene() {
  Scene scene;
  scene.name = "test";
  scene.variants = {"Day", "Night"};
  scene.materials.resize(2);
  scene.materials[0].name = "Paint";
  scene.materials[1].name = "Chrome";
  Primitive primitive;
  primitive.positions = {{-1, -1, 0}, {1, -1, 0}, {0, 1, 0}};
  primitive.indices = {0, 1, 2};
  scene.meshes.emplace_back().primitives = {primitive};
  scene.cameras = {{.name = "front", .fov_y_rad = 0.5f}, {.name = "", .fov_y_rad = 0.7f}};
  for (int i = 0; i < 3; ++i) {
    Node node;
    node.mesh = i == 0 ? 0 : -1;
    node.camera = i - 1;
    if (i > 0) node.local[3] = glm::vec4(0, i == 1 ? 0 : -2, 5, 1);
    node.name = i == 2 ? "low" : "node";
    scene.roots.push_back(i);
    scene.nodes.push_back(node);
  }
  return scene;
}

TEST(Session, CamerasByNameAndFirstByDefault) {
  const Scene scene = make_scene();
  EXPECT_EQ(camera_names(scene), (std::vector<std::string>{"front", "low"}));
  const CameraView first = camera_of_options(scene, {});
  EXPECT_EQ(first.eye, glm::vec3(0, 0, 5));
  EXPECT_EQ(first.target, glm::vec3(0, 0, 4));
  EXPECT_FLOAT_EQ(first.fov_y_rad, 0.5f);
  EXPECT_EQ(camera_by_name(scene, "low").eye, glm::vec3(0, -2, 5));
  EXPECT_NE(usage_error([&] { camera_by_name(scene, "frnt"); }).find("did you mean front?"), std::string::npos);
}

TEST(Session, OptionsOverrideTheCamera) {
  const Scene scene = make_scene();
  SceneOptions options;
  options.fov_deg = 90.0f;
  EXPECT_NEAR(camera_of_options(scene, options).fov_y_rad, 1.5707964f, 1e-6f);
  options.eye = glm::vec3(3, 0, 0);
  EXPECT_EQ(camera_of_options(scene, options).target, glm::vec3(0.0f));  // the middle of the scene
  options.eye = glm::vec3(0, 4, 0);                                      // looks straight down: another up is needed
  const CameraView down = camera_of_options(scene, options);
  EXPECT_GT(glm::length(glm::cross(glm::normalize(down.target - down.eye), down.up)), 0.9f);
  options.target = options.eye;
  EXPECT_THROW(camera_of_options(scene, options), UsageError);
}

TEST(Session, OrthographicByFileAndByOption) {
  Scene scene = make_scene();
  scene.cameras[0].height_m = 3.0f;
  EXPECT_FLOAT_EQ(camera_of_options(scene, {}).height_m, 3.0f);
  SceneOptions options;
  options.fov_deg = 40.0f;
  EXPECT_FALSE(camera_of_options(scene, options).is_orthographic());
  options.fov_deg.reset();
  options.orthographic_m = 7.0f;
  EXPECT_FLOAT_EQ(camera_of_options(scene, options).height_m, 7.0f);
  options.reflections = "bezier";
  EXPECT_NE(usage_error([&] { make_request(scene, options); }).find("orthographic"), std::string::npos);
  options.reflections = "raytraced";
  EXPECT_NO_THROW(make_request(scene, options));
}

TEST(Session, WithoutACameraTheWholeSceneIsSeen) {
  Scene scene = make_scene();
  scene.nodes.resize(1);
  scene.roots.resize(1);
  scene.nodes[0].local[0][0] = 40.0f;  // wide
  for (const auto& [width, height] : {std::pair{1280, 720}, std::pair{200, 900}}) {
    SceneOptions options;
    options.width = width;
    options.height = height;
    const CameraView view = camera_of_options(scene, options);
    const glm::vec3 forward = glm::normalize(view.target - view.eye);
    const glm::vec3 right = glm::normalize(glm::cross(forward, view.up));
    const glm::vec3 up = glm::cross(right, forward);
    const float tan_y = std::tan(0.5f * view.fov_y_rad);
    const float tan_x = tan_y * static_cast<float>(width) / static_cast<float>(height);
    for (glm::vec3 p : scene.meshes[0].primitives[0].positions) {
      p.x *= 40.0f;
      const float depth = glm::dot(p - view.eye, forward);
      EXPECT_GT(depth, 0.0f);
      EXPECT_LE(std::abs(glm::dot(p - view.eye, right)), tan_x * depth);
      EXPECT_LE(std::abs(glm::dot(p - view.eye, up)), tan_y * depth);
    }
  }
  EXPECT_NE(usage_error([&] { camera_by_name(scene, "driver"); }).find("--eye"), std::string::npos);
  EXPECT_NO_THROW(camera_of_options(Scene{}, {}));
}

TEST(Session, ANarrowPictureKeepsTheWidthOfACamera) {
  Scene scene = make_scene();
  scene.cameras[0].aspect = 1.5f;
  SceneOptions options;
  options.width = options.height = 90;
  const auto half = [](float fov_rad) { return std::tan(0.5f * fov_rad); };
  EXPECT_NEAR(half(make_request(scene, options).camera.fov_y_rad), 1.5f * half(0.5f), 1e-5f);
  options.width = 200;
  EXPECT_FLOAT_EQ(make_request(scene, options).camera.fov_y_rad, 0.5f);
  options.width = 90;
  options.fov_deg = 20.0f;  // requested: used unchanged
  EXPECT_NEAR(make_request(scene, options).camera.fov_y_rad, 0.34906585f, 1e-6f);
}

TEST(Session, VariantsAndMaterialsAreChecked) {
  const Scene scene = make_scene();
  EXPECT_EQ(find_variant(scene, ""), -1);
  EXPECT_EQ(find_variant(scene, "Night"), 1);
  EXPECT_NE(usage_error([&] { find_variant(scene, "Nigth"); }).find("did you mean Night?"), std::string::npos);
  EXPECT_NO_THROW(check_material_name(scene, "*"));
  EXPECT_NO_THROW(check_material_name(scene, "Chrome"));
  EXPECT_NE(usage_error([&] { check_material_name(scene, "chrom"); }).find("did you mean Chrome?"), std::string::npos);
}

TEST(Session, AModeThatHoldsNoGroundLeavesItToTheDefaultMode) {
  Scene scene = make_scene();
  SceneOptions options;
  options.mode = "prt";
  EXPECT_TRUE(make_request(scene, options).part_modes.empty());
  add_ground(&scene, *test::constant_sky(1.0f), {});
  ASSERT_EQ(make_request(scene, options).part_modes.size(), 1u);
  EXPECT_EQ(make_request(scene, options).part_modes[0].node, kGroundName);
  EXPECT_EQ(make_request(scene, options).part_modes[0].mode, builtin_registry().default_mode);
  options.settings.set("prt.ground", std::string("none"));
  EXPECT_TRUE(make_request(scene, options).part_modes.empty());
  options.mode = "slf";
  EXPECT_TRUE(make_request(scene, options).part_modes.empty());
}

TEST(Session, WhatIsNotAPartOfAModeIsLeftToTheDefaultMode) {
  const Scene scene = load_scene("builtin:seat");
  SceneOptions options;
  options.mode = "slf";
  EXPECT_TRUE(make_request(scene, options).part_modes.empty());
  options.settings.set("slf.parts", std::string("seat_cushion;seat_headrest"));
  const FrameRequest request = make_request(scene, options);
  const std::vector<int> layers =
      layers_of_nodes(scene, request.part_modes, {options.mode, builtin_registry().default_mode});
  int own = 0;
  for (std::size_t n = 0; n < scene.nodes.size(); ++n) {
    if (scene.nodes[n].mesh < 0) continue;
    const bool part = scene.nodes[n].name == "seat_cushion" || scene.nodes[n].name == "seat_headrest";
    EXPECT_EQ(layers[n], part ? 0 : 1) << scene.nodes[n].name;
    own += part ? 1 : 0;
  }
  EXPECT_EQ(own, 2);
}

TEST(Session, ADentGoesInwardsAndStaysLocal) {
  Scene scene = load_scene("builtin:seat");
  const std::vector<glm::mat4> world = compute_world_transforms(scene);
  std::size_t node = 0;
  while (scene.nodes[node].mesh < 0 || !scene.meshes[static_cast<std::size_t>(scene.nodes[node].mesh)].cage) ++node;
  const auto mesh = static_cast<std::size_t>(scene.nodes[node].mesh);
  const Primitive before = scene.meshes[mesh].primitives[0];
  // The highest point of the surface: its normal is near vertical, so a dent moves it down.
  std::size_t top = 0;
  const auto height = [&](const glm::vec3& p) { return (world[node] * glm::vec4(p, 1.0f)).y; };
  for (std::size_t v = 0; v < before.positions.size(); ++v)
    if (height(before.positions[v]) > height(before.positions[top])) top = v;
  Dent dent;
  dent.center = glm::vec3(world[node] * glm::vec4(before.positions[top], 1.0f));
  dent.depth_m = 0.03f;
  dent.radius_m = 0.25f;
  press_dents(&scene, {dent});
  const Primitive& after = scene.meshes[mesh].primitives[0];
  ASSERT_EQ(after.positions.size(), before.positions.size());
  const float drop = height(before.positions[top]) - height(after.positions[top]);
  EXPECT_GT(drop, 0.003f);
  EXPECT_LT(drop, 0.031f);
  for (std::size_t v = 0; v < after.positions.size(); ++v) {
    const glm::vec3 p(world[node] * glm::vec4(before.positions[v], 1.0f));
    // A control point moves the surface at most two faces around it.
    if (glm::length(p - dent.center) > 0.7f) {
      EXPECT_EQ(after.positions[v], before.positions[v]);
    }
  }
}

TEST(Session, ADentThatTouchesNothingSaysHowFar) {
  Scene scene = load_scene("builtin:seat");
  Dent dent;
  dent.center = glm::vec3(50.0f, 0.0f, 0.0f);
  dent.depth_m = 0.1f;
  dent.radius_m = 0.2f;
  try {
    press_dents(&scene, {dent});
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find("m away"), std::string::npos) << error.what();
  }
  Scene plain = make_scene();
  EXPECT_THROW(press_dents(&plain, {dent}), Error);
}

TEST(Session, AGroundIsAddedOnlyBelowSomething) {
  Environment environment;
  environment.width = 4;
  environment.height = 2;
  environment.rgb.assign(8, glm::vec3(1.0f));
  Settings settings;
  const auto nothing = std::make_shared<const Scene>(),
             sphere = std::make_shared<const Scene>(load_scene("builtin:sphere"));
  EXPECT_EQ(with_ground(sphere, environment, settings, 0.0f), sphere);
  settings.set("ground.kind", std::string("projected"));
  EXPECT_EQ(with_ground(nothing, environment, settings, 0.0f), nothing);
  const auto grounded = with_ground(sphere, environment, settings, 0.5f);
  EXPECT_EQ(grounded->nodes.size(), sphere->nodes.size() + 1);
  EXPECT_EQ(framed_bounds(*grounded).max, compute_bounds(*sphere).max);
}

TEST(Session, TheFirstViewIsFromTheFront) {
  Scene scene = load_scene("builtin:sphere");
  scene.cameras.clear();
  for (Node& node : scene.nodes) node.camera = -1, node.name = "part";
  const auto add = [&](const std::string& name, float z) {
    Node node;
    node.name = name;
    node.local[3] = glm::vec4(0.0f, 0.0f, z, 1.0f);
    scene.roots.push_back(static_cast<int>(scene.nodes.size()));
    scene.nodes.push_back(node);
  };
  const SceneOptions options;
  EXPECT_GT(camera_of_options(scene, options).eye.z, 0.0f) << "as glTF has it";
  add("wheel_fl", -1.2f);
  EXPECT_GT(camera_of_options(scene, options).eye.z, 0.0f) << "nothing to compare with";
  add("wheel_rl", 1.4f);
  EXPECT_LT(camera_of_options(scene, options).eye.z, 0.0f);
  add("Bumper Front", 9.0f);
  EXPECT_GT(camera_of_options(scene, options).eye.z, 0.0f);
}

TEST(Session, MaterialsOfColoursOnlyAreNamed) {
  Scene scene = load_scene("builtin:sphere");
  scene.materials.assign(3, test::matte(glm::vec3(0.5f)));
  EXPECT_NE(gloss_warning(scene).find("3 materials have neither gloss nor glass"), std::string::npos);
  for (Material& m : scene.materials) m.roughness = 0.8f;
  EXPECT_NE(gloss_warning(scene), "");
  scene.materials[1].roughness = 0.3f;
  EXPECT_EQ(gloss_warning(scene), "");
  scene.materials[1] = test::clear_pane();
  EXPECT_EQ(gloss_warning(scene), "");
  EXPECT_EQ(gloss_warning(Scene()), "");
  EXPECT_EQ(gloss_warning(load_scene("builtin:cockpit")), "");
}

TEST(Session, LampsThatOutshineAnEnvironmentAreDoubted) {
  Scene scene = load_scene("builtin:sphere");
  Environment environment;
  environment.name = "hall.hdr";
  environment.width = 64;
  environment.height = 32;
  environment.rgb.assign(2048, glm::vec3(0.6f));
  EXPECT_EQ(units_warning(scene, environment, 1.0f, "--env-scale"), "") << "no lamps";
  scene.materials.front().emissive = glm::vec3(400.0f);
  EXPECT_EQ(units_warning(scene, environment, 1.0f, "--env-scale"),
            "about 0.6 cd/m2 on average, the scene's lamps up to 400: as at night. If the file is in units of its own, "
            "--env-scale 800 lights it as a hall");
  EXPECT_EQ(units_warning(scene, environment, 800.0f, "--env-scale"), "");
  float suited = 0.0f;
  units_warning(scene, environment, 1.0f, "", &suited);
  EXPECT_EQ(suited, 800.0f);
  EXPECT_EQ(units_warning(scene, environment, 0.0f, "--env-scale"), "") << "dark on purpose";
  environment.rgb.assign(2048, glm::vec3(0.0f));
  EXPECT_EQ(units_warning(scene, environment, 1.0f, "--env-scale"), "") << "black on purpose";
  EXPECT_EQ(units_warning(load_scene("builtin:cockpit"), load_environment("builtin:studio"), 1e-9f, ""), "")
      << "in cd/m2";
}

TEST(Session, TurnsANodeAboutItsOwnOrigin) {
  Scene scene;
  scene.nodes.resize(2);
  scene.nodes[0].name = "part";
  scene.nodes[0].mesh = 0;
  scene.nodes[0].local[3] = glm::vec4(1, 2, 3, 1);
  scene.nodes[1].camera = 0;
  scene.nodes[1].local[3] = glm::vec4(0, 0, 5, 1);
  scene.roots = {0, 1};
  turn_node(&scene, {"part", {0, 1, 0}, 90.0f});
  EXPECT_EQ(glm::vec3(scene.nodes[0].local[3]), glm::vec3(1, 2, 3));
  EXPECT_NEAR(glm::length(glm::vec3(scene.nodes[0].local * glm::vec4(0, 0, 1, 0)) - glm::vec3(1, 0, 0)), 0.0f, 1e-6f);
  turn_node(&scene, {"*", {0, 1, 0}, 90.0f});
  EXPECT_NEAR(glm::length(glm::vec3(scene.nodes[0].local[3]) - glm::vec3(3, 2, -1)), 0.0f, 1e-6f);
  EXPECT_EQ(scene.nodes[1].local[3], glm::vec4(0, 0, 5, 1)) << "cameras stay";
  EXPECT_THROW(turn_node(&scene, {"prat", {0, 1, 0}, 1.0f}), UsageError);
}

}  // namespace
}  // namespace maquette
