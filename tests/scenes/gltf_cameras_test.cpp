#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/constants.hpp>

#include "gltf_fixture.h"

namespace maquette {
namespace {

/// Cameras and lamps: what is wrong with them is repaired or they are left out, with one warning, and the scene loads.
class GltfCameras : public test::GltfFixture {
 protected:
  GltfCameras() { add_quad(); }

  /// The scene with `camera` on a node of its own.
  Scene with_camera(const std::string& camera) {
    root_["cameras"] = test::Json::array({test::Json::parse(camera)});
    root_["nodes"] = test::Json::parse(R"([{"mesh": 0}, {"camera": 0, "name": "eye"}])");
    root_["scenes"][0]["nodes"] = {0, 1};
    return checked();
  }
  Scene with_lens(const std::string& lens) {
    return with_camera(R"({"type": "perspective", "perspective": )" + lens + "}");
  }
  Scene with_light(const std::string& light) {
    root_["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 0;
    root_["extensions"]["KHR_lights_punctual"]["lights"] = test::Json::array({test::Json::parse(light)});
    return checked();
  }
  Scene checked() const {
    Scene scene = load();
    EXPECT_EQ(count_triangles(scene), 2u);
    for (const Node& node : scene.nodes) {
      EXPECT_LT(node.camera, static_cast<int>(scene.cameras.size()));
      EXPECT_LT(node.light, static_cast<int>(scene.lights.size()));
    }
    return scene;
  }
  /// One warning, of `element` and `fault`.
  static void expect_one(const Scene& scene, const std::string& element, const std::string& fault) {
    ASSERT_EQ(scene.warnings.size(), 1u) << fault;
    EXPECT_TRUE(scene.warnings[0].starts_with(element + ": ")) << scene.warnings[0];
    EXPECT_NE(scene.warnings[0].find(fault), std::string::npos) << scene.warnings[0];
  }
};

TEST_F(GltfCameras, WithoutZfarAreInfinite) {
  const Scene scene = with_lens(R"({"yfov": 0.5, "znear": 0.25})");
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_TRUE(std::isinf(scene.cameras.at(0).far_m));
  EXPECT_FLOAT_EQ(scene.cameras[0].near_m, 0.25f);
  save_glb(path("saved.glb"), scene);
  const Scene again = load_gltf(path("saved.glb"));
  EXPECT_TRUE(again.warnings.empty());
  EXPECT_TRUE(std::isinf(again.cameras.at(0).far_m));
}

TEST_F(GltfCameras, ThatCanBeRepairedAre) {
  const std::string at = "cameras[0]";
  Scene scene = with_lens(R"({"yfov": 0.5, "znear": 0.1, "zfar": 0.05})");
  expect_one(scene, at, "zfar is not beyond znear");
  EXPECT_TRUE(std::isinf(scene.cameras.at(0).far_m));
  scene = with_lens(R"({"yfov": 0.5, "znear": 0})");
  expect_one(scene, at, "znear is not above 0");
  EXPECT_FLOAT_EQ(scene.cameras.at(0).near_m, 0.01f);
  scene = with_lens(R"({"yfov": 0.5, "znear": -1, "zfar": 0.1})");
  expect_one(scene, at, "znear is not above 0");
  EXPECT_FLOAT_EQ(scene.cameras.at(0).near_m, 0.0001f);
  EXPECT_FLOAT_EQ(scene.cameras[0].far_m, 0.1f);
  expect_one(with_lens(R"({"yfov": 0.5})"), at, "znear is not above 0");
  expect_one(with_lens(R"({"yfov": 0.5, "znear": "near"})"), at, "znear is not a number");
  scene = with_lens(R"({"yfov": 0.5, "znear": 1, "zfar": [2]})");
  expect_one(scene, at, "zfar is not a number");
  EXPECT_TRUE(std::isinf(scene.cameras.at(0).far_m));
  scene = with_lens(R"({"yfov": 0.5, "znear": 1, "aspectRatio": 0})");
  expect_one(scene, at, "aspectRatio");
  EXPECT_EQ(scene.cameras.at(0).aspect, 0.0f);
  expect_one(with_lens(R"({"yfov": 0.5, "znear": -1, "zfar": -2, "aspectRatio": -3})"), at, "zfar is not beyond");
  expect_one(with_camera(R"({"name": 3, "type": "perspective", "perspective": {"yfov": 1, "znear": 1}})"), at, "name");
}

TEST_F(GltfCameras, ThatCannotBeRepairedAreLeftOut) {
  for (const char* lens : {R"({"yfov": 0, "znear": 1})", R"({"yfov": -1, "znear": 1})", R"({"yfov": 3.15, "znear": 1})",
                           R"({"znear": 1})", R"({"yfov": "wide", "znear": 1})", R"({"yfov": 1e300, "znear": 1})"}) {
    const Scene scene = with_lens(lens);
    expect_one(scene, "cameras[0]", "left out: yfov");
    EXPECT_TRUE(scene.cameras.empty());
    EXPECT_EQ(scene.nodes.at(1).camera, -1);
  }
  for (const char* camera : {R"({"type": "perspective"})", R"({"type": "perspective", "perspective": 3})", "{}", "7",
                             R"({"type": 4, "perspective": {"yfov": 0.5, "znear": 1}})"})
    expect_one(with_camera(camera), "cameras[0]", "neither perspective nor orthographic");
}

TEST_F(GltfCameras, Orthographic) {
  const auto with_mags = [&](const std::string& rest) {
    return with_camera(R"({"type": "orthographic", "orthographic": {)" + rest + "}}");
  };
  const Scene scene = with_mags(R"("xmag": 3, "ymag": 2, "znear": 0, "zfar": 20)");
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_FLOAT_EQ(scene.cameras.at(0).height_m, 4.0f);
  EXPECT_FLOAT_EQ(scene.cameras[0].aspect, 1.5f);
  EXPECT_EQ(scene.cameras[0].near_m, 0.0f);
  EXPECT_FLOAT_EQ(scene.cameras[0].far_m, 20.0f);
  save_glb(path("saved.glb"), scene);
  const Scene again = load_gltf(path("saved.glb"));
  EXPECT_TRUE(again.warnings.empty());
  EXPECT_FLOAT_EQ(again.cameras.at(0).height_m, 4.0f);
  EXPECT_FLOAT_EQ(again.cameras[0].aspect, 1.5f);
  const Scene mirrored = with_mags(R"("xmag": -3, "ymag": 2, "znear": 1, "zfar": 20)");
  expect_one(mirrored, "cameras[0]", "not mirrored");
  EXPECT_FLOAT_EQ(mirrored.cameras.at(0).aspect, 1.5f);
  expect_one(with_mags(R"("xmag": 3, "ymag": 2, "znear": -1, "zfar": 20)"), "cameras[0]", "znear is not above 0");
  expect_one(with_mags(R"("xmag": 3, "ymag": 2, "znear": 5, "zfar": 4)"), "cameras[0]", "zfar is not beyond");
  for (const char* mags : {R"("xmag": 0, "ymag": 2)", R"("xmag": 1)", R"("xmag": 1, "ymag": "high")"})
    expect_one(with_mags(mags), "cameras[0]", "xmag or ymag is 0 or missing");
}

TEST_F(GltfCameras, NodesWithoutOne) {
  root_["cameras"] = test::Json::parse(R"([{"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}])");
  for (const test::Json& camera : {test::Json(1), test::Json(-1), test::Json("eye"), test::Json(0.5)}) {
    root_["nodes"][0]["camera"] = camera;
    expect_one(checked(), "nodes[0]", "names a camera that is not there");
  }
  root_["nodes"][0]["camera"] = 0;
  root_["cameras"] = 3;
  EXPECT_EQ(checked().warnings.size(), 2u);
  root_["cameras"] = test::Json::parse(R"([{"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}])");
  root_["nodes"] = test::Json::parse(R"([{"mesh": 0}, {"camera": 0, "scale": [0, 1, 1], "name": "flat"},
      {"camera": 0, "scale": [1, 1, 0], "name": "thin"}])");
  root_["scenes"][0]["nodes"] = {0, 1, 2};
  const Scene scene = checked();
  EXPECT_EQ(scene.nodes[1].camera, 0);  // the axis of x is not needed
  EXPECT_EQ(scene.nodes[2].camera, -1);
  expect_one(scene, "node \"thin\"", "scale is 0");
}

TEST_F(GltfCameras, OfTwoNodesHaveTheNamesOfBoth) {
  root_["cameras"] = test::Json::parse(R"([{"type": "perspective", "perspective": {"yfov": 1, "znear": 1}}])");
  root_["nodes"] = test::Json::parse(R"([{"mesh": 0}, {"camera": 0, "name": "front"}, {"camera": 0, "name": "back"}])");
  root_["scenes"][0]["nodes"] = {0, 1, 2};
  const Scene scene = checked();
  ASSERT_EQ(scene.cameras.size(), 2u);
  EXPECT_EQ(scene.cameras[static_cast<std::size_t>(scene.nodes[1].camera)].name, "front");
  EXPECT_EQ(scene.cameras[static_cast<std::size_t>(scene.nodes[2].camera)].name, "back");
  EXPECT_TRUE(scene.warnings.empty());
}

TEST_F(GltfCameras, ConesOfSpots) {
  const std::string at = "KHR_lights_punctual.lights[0]";
  const auto spot = [this](const std::string& cone) { return with_light(R"({"type": "spot", "spot": )" + cone + "}"); };
  const auto expect_cone = [](const Scene& scene, float inner, float outer) {
    ASSERT_EQ(scene.lights.size(), 1u);
    EXPECT_FLOAT_EQ(scene.lights[0].inner_cone_rad, inner);
    EXPECT_FLOAT_EQ(scene.lights[0].outer_cone_rad, outer);
    EXPECT_LT(scene.lights[0].inner_cone_rad, scene.lights[0].outer_cone_rad);
  };
  const float quarter = glm::quarter_pi<float>(), half = glm::half_pi<float>();
  for (const char* cone : {"{}", R"({"innerConeAngle": 0})", R"({"outerConeAngle": 0.7853981633974483})"}) {
    const Scene scene = spot(cone);
    EXPECT_TRUE(scene.warnings.empty());
    expect_cone(scene, 0.0f, quarter);
  }
  EXPECT_TRUE(with_light(R"({"type": "spot"})").warnings.empty());
  EXPECT_TRUE(spot(R"({"outerConeAngle": 1.5707964})").warnings.empty());
  Scene scene = spot(R"({"innerConeAngle": 0.6, "outerConeAngle": 0.6})");
  expect_one(scene, at, "sharp edge");
  expect_cone(scene, 0.6f, 0.6f);
  scene = spot(R"({"innerConeAngle": 0.7, "outerConeAngle": 0.6})");
  expect_one(scene, at, "sharp edge");
  expect_cone(scene, 0.6f, 0.6f);
  scene = spot(R"({"innerConeAngle": 0.8})");
  expect_one(scene, at, "sharp edge");
  expect_cone(scene, quarter, quarter);
  scene = spot(R"({"innerConeAngle": 0.1, "outerConeAngle": 2})");
  expect_one(scene, at, "beyond pi/2");
  expect_cone(scene, 0.1f, half);
  scene = spot(R"({"innerConeAngle": 3, "outerConeAngle": 2})");
  expect_one(scene, at, "beyond pi/2");
  expect_cone(scene, half, half);
  scene = spot(R"({"innerConeAngle": -0.1, "outerConeAngle": 0.5})");
  expect_one(scene, at, "innerConeAngle below 0");
  expect_cone(scene, 0.0f, 0.5f);
  scene = spot(R"({"outerConeAngle": "wide"})");
  expect_one(scene, at, "outerConeAngle is not a number");
  expect_cone(scene, 0.0f, quarter);
  for (const char* cone : {R"({"outerConeAngle": 0})", R"({"outerConeAngle": -1})"}) {
    scene = spot(cone);
    expect_one(scene, at, "the spot is left out");
    EXPECT_TRUE(scene.lights.empty());
    EXPECT_EQ(scene.nodes[0].light, -1);
  }
}

TEST_F(GltfCameras, LampsOfOtherFaults) {
  const std::string at = "KHR_lights_punctual.lights[0]";
  Scene scene = with_light(R"({"type": "laser"})");
  expect_one(scene, at, "\"laser\" is not directional, point or spot");
  EXPECT_EQ(scene.nodes[0].light, -1);
  expect_one(with_light("{}"), at, "left out");
  expect_one(with_light("3"), at, "left out");
  scene = with_light(R"({"type": "point", "range": 0})");
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_EQ(scene.lights.at(0).range_m, 0.0f);
  expect_one(with_light(R"({"type": "point", "range": -2})"), at, "range below 0");
  scene = with_light(R"({"type": "point", "color": [1, -1, 0.5], "intensity": -3})");
  expect_one(scene, at, "color below 0 is clamped; intensity below 0 is clamped");
  EXPECT_EQ(scene.lights.at(0).color, glm::vec3(1.0f, 0.0f, 0.5f));
  EXPECT_EQ(scene.lights[0].intensity, 0.0f);
  scene = with_light(R"({"type": "point", "color": "red", "intensity": 1e39})");
  expect_one(scene, at, "color is not three numbers");
  EXPECT_EQ(scene.lights.at(0).color, glm::vec3(1.0f));
  EXPECT_EQ(scene.lights[0].intensity, 1.0f);
  expect_one(with_light(R"({"type": "point", "color": [1, 1]})"), at, "color is not three numbers");
  with_light(R"({"type": "point"})");
  root_["nodes"][0]["extensions"]["KHR_lights_punctual"]["light"] = 1;
  expect_one(checked(), "nodes[0]", "names a lamp that is not there");
  root_["nodes"][0]["extensions"]["KHR_lights_punctual"] = test::Json::object();
  expect_one(checked(), "nodes[0]", "names a lamp that is not there");
  root_["nodes"][0].erase("extensions");
  root_["extensions"]["KHR_lights_punctual"]["lights"] = 5;
  expect_one(checked(), "KHR_lights_punctual.lights", "is not an array");
}

/// Many of one kind make one line.
TEST_F(GltfCameras, ManyLampsMakeOneWarning) {
  auto& lights = root_["extensions"]["KHR_lights_punctual"]["lights"];
  for (int i = 0; i < 10; ++i) lights.push_back({{"type", "point"}, {"intensity", -1 - i}});
  expect_one(checked(), "KHR_lights_punctual.lights[0] and 9 more", "intensity below 0");
}

}  // namespace
}  // namespace maquette
