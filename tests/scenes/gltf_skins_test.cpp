#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>
#include <glm/gtc/type_ptr.hpp>

#include "gltf_fixture.h"

namespace maquette {
namespace {

/// Morph targets, skins and instances in the rest pose, against closed forms.
class GltfSkins : public test::GltfFixture {
 protected:
  GltfSkins() {
    add_quad();
    primitive()["attributes"]["NORMAL"] = add_accessor<float>({0, 0, 1, 0, 0, 1, 0, 0, 1, 0, 0, 1}, 5126, "VEC3", 3);
    primitive()["attributes"]["TANGENT"] =
        add_accessor<float>({1, 0, 0, -1, 1, 0, 0, -1, 1, 0, 0, -1, 1, 0, 0, -1}, 5126, "VEC4", 4);
  }
  /// World positions of the first primitive under the node of that name.
  static std::vector<glm::vec3> points_of(const Scene& scene, const std::string& node) {
    const std::vector<glm::mat4> world = compute_world_transforms(scene);
    for (std::size_t i = 0; i < scene.nodes.size(); ++i) {
      if (scene.nodes[i].name != node || scene.nodes[i].mesh < 0) continue;
      std::vector<glm::vec3> out;
      for (const glm::vec3& p : scene.meshes[static_cast<std::size_t>(scene.nodes[i].mesh)].primitives.at(0).positions)
        out.emplace_back(world[i] * glm::vec4(p, 1.0f));
      return out;
    }
    ADD_FAILURE() << "no mesh at " << node;
    return std::vector<glm::vec3>(4);
  }
  static void expect_near(const glm::vec3& a, const glm::vec3& b) {
    EXPECT_LT(glm::distance(a, b), 1e-5f)
        << a.x << " " << a.y << " " << a.z << " and " << b.x << " " << b.y << " " << b.z;
  }
  int add_matrices(const std::vector<glm::mat4>& matrices) {
    std::vector<float> flat;
    for (const glm::mat4& m : matrices) flat.insert(flat.end(), glm::value_ptr(m), glm::value_ptr(m) + 16);
    return add_accessor<float>(flat, 5126, "MAT4", 16);
  }
  /// Vertices 0 and 1 follow joint 0, vertex 2 joint 1, vertex 3 both.
  void bind(const std::vector<float>& weights = {1, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0.5f, 0.5f, 0, 0}) {
    primitive()["attributes"]["JOINTS_0"] =
        add_accessor<std::uint8_t>({0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0}, 5121, "VEC4", 4);
    primitive()["attributes"]["WEIGHTS_0"] = add_accessor<float>(weights, 5126, "VEC4", 4);
  }
};

TEST_F(GltfSkins, MorphTargetsByTheWeightsOfTheMesh) {
  auto& targets = primitive()["targets"];
  targets = test::Json::array();
  targets.push_back({{"POSITION", add_accessor<float>({0, 0, 1, 0, 0, 2, 0, 0, 3, 0, 0, 4}, 5126, "VEC3", 3)},
                     {"NORMAL", add_accessor<float>({1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 5126, "VEC3", 3)},
                     {"TANGENT", add_accessor<float>({0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 5126, "VEC3", 3)}});
  targets.push_back({{"POSITION", add_accessor<float>({8, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 5126, "VEC3", 3)}});
  root_["meshes"][0]["weights"] = {0.5, 0.25};
  const Scene scene = load();
  EXPECT_TRUE(scene.warnings.empty());
  const Primitive& out = scene.meshes[0].primitives[0];
  expect_near(out.positions[0], {2, 0, 0.5f});
  expect_near(out.positions[1], {1, 0, 1});
  expect_near(out.positions[2], {1, 1, 1.5f});
  expect_near(out.normals[0], glm::vec3(0.5f, 0, 1));
  expect_near(out.normals[1], glm::vec3(0, 0, 1));
  expect_near(glm::vec3(out.tangents[0]), {1, 1, 0});
  EXPECT_EQ(out.tangents[0].w, -1.0f);
}

/// Nodes have weights of their own; meshes are shared where they are the same.
TEST_F(GltfSkins, MorphTargetsByTheWeightsOfNodes) {
  // Sparse values on zeros: vertex 2 alone moves.
  const int places = add_view<std::uint16_t>({2}), values = add_view<float>({0, 0, 6});
  root_["accessors"].push_back({{"componentType", 5126},
                                {"count", 4},
                                {"type", "VEC3"},
                                {"sparse",
                                 {{"count", 1},
                                  {"indices", {{"bufferView", places}, {"componentType", 5123}}},
                                  {"values", {{"bufferView", values}}}}}});
  primitive()["targets"] = {{{"POSITION", root_["accessors"].size() - 1}}};
  primitive()["attributes"].erase("NORMAL");
  root_["nodes"] = test::Json::parse(R"([{"name": "a", "mesh": 0}, {"name": "b", "mesh": 0, "weights": [0.5]},
      {"name": "c", "mesh": 0, "weights": [0.5, 0, 0]}, {"name": "d", "mesh": 0, "weights": [1]}])");
  root_["scenes"][0]["nodes"] = {0, 1, 2, 3};
  const Scene scene = load();
  EXPECT_TRUE(scene.warnings.empty());
  EXPECT_EQ(scene.meshes.size(), 3u);
  EXPECT_EQ(scene.nodes[1].mesh, scene.nodes[2].mesh);
  expect_near(points_of(scene, "a")[2], {1, 1, 0});
  expect_near(points_of(scene, "b")[2], {1, 1, 3});
  expect_near(points_of(scene, "d")[2], {1, 1, 6});
  expect_near(points_of(scene, "d")[1], {1, 0, 0});
  // Missing normals are those of the moved triangles.
  const Primitive& moved = scene.meshes[static_cast<std::size_t>(scene.nodes[3].mesh)].primitives[0];
  const glm::vec3 expected = glm::normalize(glm::cross(glm::vec3(1, 0, 0), glm::vec3(1, 1, 6)));
  expect_near(moved.normals[moved.indices[1]], expected);
  primitive()["targets"][0]["POSITION"] = add_accessor<float>({0, 0, 1}, 5126, "VEC3", 3);
  expect_error("meshes[0].primitives[0].targets[0].POSITION: has 1 values for 4 vertices");
}

/// Vertices follow their joints; the transform of the skinned node itself does not count.
TEST_F(GltfSkins, SkinsFollowTheirJoints) {
  bind();
  root_["nodes"] = test::Json::parse(R"([
      {"name": "skinned", "mesh": 0, "skin": 0, "translation": [100, 0, 0], "rotation": [0, 0.6, 0, 0.8], "scale": [3, 2, 1]},
      {"name": "bone", "translation": [0, 0, 5], "children": [2]},
      {"name": "tip", "translation": [0, 2, 0], "rotation": [0, 0, 0.70710678118, 0.70710678118]}])");
  root_["scenes"][0]["nodes"] = {0, 1};
  const glm::mat4 bind_tip = glm::translate(glm::mat4(1.0f), glm::vec3(0, -1, 0));
  root_["skins"] = {{{"joints", {1, 2}}, {"inverseBindMatrices", add_matrices({glm::mat4(1.0f), bind_tip})}}};
  const Scene scene = load();
  expect_warning(scene, "zero area");  // of the second triangle in this pose
  const std::vector<glm::vec3> points = points_of(scene, "skinned");
  expect_near(points[0], {0, 0, 5});
  expect_near(points[1], {1, 0, 5});
  // (1, 1, 0) is (1, 0, 0) from the tip, which a quarter turn about z takes to (0, 1, 0); the tip is at (0, 2, 5).
  expect_near(points[2], {0, 3, 5});
  // (0, 1, 0) is the tip: half of (0, 1, 5) and half of (0, 2, 5).
  expect_near(points[3], {0, 1.5f, 5});
  // Normals and tangents in the world: those of joint 0 as they were, the tangent of joint 1 turned to +y.
  const glm::mat4 world = compute_world_transforms(scene)[0];
  const Primitive& out = scene.meshes[0].primitives[0];
  const glm::mat3 normal_matrix = glm::transpose(glm::inverse(glm::mat3(world)));
  expect_near(glm::normalize(normal_matrix * out.normals[0]), {0, 0, 1});
  expect_near(glm::normalize(normal_matrix * out.normals[2]), {0, 0, 1});
  expect_near(glm::normalize(glm::mat3(world) * glm::vec3(out.tangents[0])), {1, 0, 0});
  expect_near(glm::normalize(glm::mat3(world) * glm::vec3(out.tangents[2])), {0, 1, 0});
  EXPECT_EQ(out.tangents[2].w, -1.0f);
  save_glb(path("saved.glb"), scene);
  expect_near(points_of(load_gltf(path("saved.glb")), "skinned")[2], {0, 3, 5});
}

/// Two nodes with one mesh and different skins show two poses; a node without volume does not matter.
TEST_F(GltfSkins, SkinsOfSeveralNodes) {
  bind();
  root_["nodes"] = test::Json::parse(R"([
      {"name": "a", "mesh": 0, "skin": 0, "scale": [0, 0, 0]}, {"name": "b", "mesh": 0, "skin": 1}, {"name": "c", "mesh": 0},
      {"translation": [0, 0, 1]}, {"translation": [0, 0, 2]}])");
  root_["scenes"][0]["nodes"] = {0, 1, 2, 3, 4};
  root_["skins"] = {{{"joints", {3, 3}}}, {{"joints", {4, 4}}}};
  const Scene scene = load();
  expect_near(points_of(scene, "a")[2], {1, 1, 1});
  expect_near(points_of(scene, "b")[2], {1, 1, 2});
  expect_near(points_of(scene, "c")[2], {1, 1, 0});
  EXPECT_EQ(count_triangles(scene), 6u);
}

/// Targets move vertices before joints do.
TEST_F(GltfSkins, MorphedSkins) {
  bind();
  primitive()["targets"] = {{{"POSITION", add_accessor<float>({1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}, 5126, "VEC3", 3)}}};
  root_["meshes"][0]["weights"] = {2};
  root_["nodes"] = test::Json::parse(
      R"([{"name": "a", "mesh": 0, "skin": 0}, {"rotation": [0, 0, 0.70710678118, 0.70710678118]}, {}])");
  root_["scenes"][0]["nodes"] = {0, 1, 2};
  root_["skins"] = {{{"joints", {1, 2}}}};
  const Scene scene = load();
  expect_near(points_of(scene, "a")[0], {0, 2, 0});
}

/// Weights of other sums are scaled; normalised integers and a second set count.
TEST_F(GltfSkins, WeightsOfAllKinds) {
  root_["nodes"] = test::Json::parse(
      R"([{"name": "a", "mesh": 0, "skin": 0}, {"translation": [0, 0, 1]}, {"translation": [0, 0, 3]}])");
  root_["scenes"][0]["nodes"] = {0, 1, 2};
  root_["skins"] = {{{"joints", {1, 2}}}};
  bind({2, 0, 0, 0, 0.25f, 0.25f, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0});
  std::vector<glm::vec3> points = points_of(load(), "a");
  expect_near(points[0], {0, 0, 1});
  expect_near(points[1], {1, 0, 2});
  expect_near(points[2], {1, 1, 1});  // no weight at all: the first joint
  primitive()["attributes"]["WEIGHTS_0"] =
      add_accessor<std::uint8_t>({255, 0, 0, 0, 0, 255, 0, 0, 51, 204, 0, 0, 51, 0, 0, 0}, 5121, "VEC4", 4, true);
  primitive()["attributes"]["JOINTS_1"] =
      add_accessor<std::uint16_t>({1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0, 1, 0, 0, 0}, 5123, "VEC4", 4);
  primitive()["attributes"]["WEIGHTS_1"] =
      add_accessor<std::uint8_t>({0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 204, 0, 0, 0}, 5121, "VEC4", 4, true);
  points = points_of(load(), "a");
  expect_near(points[0], {0, 0, 1});
  expect_near(points[1], {1, 0, 3});
  expect_near(points[2], {1, 1, 2.6f});
  expect_near(points[3], {0, 1, 2.6f});
}

TEST_F(GltfSkins, BadSkins) {
  bind();
  root_["nodes"] = test::Json::parse(R"([{"mesh": 0, "skin": 0}, {}])");
  root_["skins"] = {{{"joints", {1}}}};
  expect_error("meshes[0].primitives[0]: a vertex follows joint 1 of 1");
  root_["skins"] = {{{"joints", {1, 1}}, {"inverseBindMatrices", add_matrices({glm::mat4(1.0f)})}}};
  expect_error("skins[0].inverseBindMatrices: has 1 matrices for 2 joints");
  root_["skins"][0]["inverseBindMatrices"] = 0;
  expect_error("accessors[0]: does not hold matrices");
  root_["skins"][0].erase("inverseBindMatrices");
  primitive()["attributes"].erase("WEIGHTS_0");
  expect_error("JOINTS_0 and WEIGHTS_0");
  root_["skins"] = {{{"joints", {7}}}};
  expect_error("skins[0].joints[0]: 7 is out of range");
  root_["nodes"][0]["skin"] = 3;
  expect_error("nodes[0].skin: 3 is out of range");
}

TEST_F(GltfSkins, InstancesOfOneNode) {
  root_["nodes"] = test::Json::parse(
      R"([{"name": "seat", "mesh": 0, "translation": [0, 0, 7], "children": [1], "extras": {"maquette": {"reflector": true}}},
      {"name": "child"}])");
  auto& attributes = root_["nodes"][0]["extensions"]["EXT_mesh_gpu_instancing"]["attributes"];
  attributes["TRANSLATION"] = add_accessor<float>({0, 0, 0, 5, 0, 0}, 5126, "VEC3", 3);
  attributes["ROTATION"] = add_accessor<std::int16_t>({0, 0, 0, 32767, 0, 0, 23170, 23170}, 5122, "VEC4", 4, true);
  attributes["SCALE"] = add_accessor<float>({1, 1, 1, 2, 3, 4}, 5126, "VEC3", 3);
  root_["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
  const auto check = [](const Scene& scene) {
    EXPECT_TRUE(scene.warnings.empty());
    EXPECT_EQ(count_triangles(scene), 4u);
    ASSERT_EQ(scene.nodes.size(), 4u);
    EXPECT_EQ(scene.nodes[0].mesh, -1);
    EXPECT_EQ(scene.nodes[0].children.size(), 3u);
    EXPECT_TRUE(scene.nodes[2].reflector);
    expect_near(points_of(scene, "seat-0")[2], {1, 1, 7});
    expect_near(points_of(scene, "seat-1")[2], {2, 2, 7});  // (2, 3) turned to (-3, 2), and 5 to the right
  };
  const Scene scene = load();
  check(scene);
  save_glb(path("saved.glb"), scene);
  check(load_gltf(path("saved.glb")));
  attributes["SCALE"] = add_accessor<float>({1, 1, 1}, 5126, "VEC3", 3);
  expect_error("SCALE: has 1 instances, expected 2");
  attributes.erase("SCALE");
  attributes["_TINT"] = attributes["TRANSLATION"];
  expect_warning(load(), "nodes[0]: the attribute _TINT of instances is ignored");
  attributes = {{"TRANSLATION", 99}};
  expect_error("TRANSLATION: 99 is out of range");
}

TEST_F(GltfSkins, ScenesByNameOrIndex) {
  root_["nodes"] =
      test::Json::parse(R"([{"name": "a", "mesh": 0}, {"name": "b", "mesh": 0}, {"name": "c", "mesh": 0}])");
  root_["scenes"] =
      test::Json::parse(R"([{"name": "day", "nodes": [0]}, {"name": "night", "nodes": [1, 2]}, {"nodes": [2]}])");
  const std::string file = write_glb();
  const Scene all = load_gltf(file);
  EXPECT_EQ(all.nodes.size(), 1u);
  expect_warning(all, "only the default of 3 scenes is shown; --scene chooses another: 0 \"day\", 1 \"night\", 2");
  const Scene night = load_gltf(file, "night");
  EXPECT_EQ(night.nodes.size(), 2u);
  EXPECT_TRUE(night.warnings.empty());
  EXPECT_EQ(load_gltf(file, "1").nodes.size(), 2u);
  EXPECT_EQ(load_scene(file, "2").nodes.at(0).name, "c");
  for (const char* wrong : {"dusk", "3", "-1", "1.0"}) {
    try {
      load_gltf(file, wrong);
      ADD_FAILURE() << wrong;
    } catch (const UsageError& e) {
      EXPECT_NE(std::string(e.what()).find("it has 0 \"day\", 1 \"night\", 2"), std::string::npos) << e.what();
    }
  }
  EXPECT_THROW(load_scene("builtin:plate", "0"), UsageError);
}

}  // namespace
}  // namespace maquette
