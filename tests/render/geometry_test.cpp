#include "render/scene_state/geometry.h"

#include <gtest/gtest.h>

#include <cmath>
#include <glm/gtc/matrix_transform.hpp>

#include "scenes/error.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

/// A unit quad in z = 0 facing +z, two triangles, UVs along x and y.
Primitive quad() {
  Primitive out;
  out.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}};
  out.uvs[0] = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  out.indices = {0, 1, 2, 0, 2, 3};
  return out;
}

Scene scene_of(Primitive primitive, const glm::mat4& local = glm::mat4(1.0f)) {
  Scene scene;
  scene.meshes.emplace_back().primitives.push_back(std::move(primitive));
  Node& node = scene.nodes.emplace_back();
  node.mesh = 0;
  node.local = local;
  scene.roots = {0};
  return scene;
}

glm::vec3 face_normal(const FlatGeometry& flat, std::size_t triangle) {
  const std::uint32_t* t = &flat.indices[3 * triangle];
  return glm::normalize(
      glm::cross(flat.positions[t[1]] - flat.positions[t[0]], flat.positions[t[2]] - flat.positions[t[0]]));
}

void expect_valid(const FlatGeometry& flat) {
  for (std::size_t i = 0; i < flat.positions.size(); ++i) {
    EXPECT_NEAR(glm::length(flat.normals[i]), 1.0f, 1e-5f);
    EXPECT_NEAR(glm::length(glm::vec3(flat.tangents[i])), 1.0f, 1e-5f);
    EXPECT_NEAR(glm::dot(glm::vec3(flat.tangents[i]), flat.normals[i]), 0.0f, 1e-5f);
    EXPECT_EQ(std::abs(flat.tangents[i].w), 1.0f);
  }
}

TEST(Flatten, FillsWhatIsMissing) {
  const FlatGeometry flat = flatten(scene_of(quad()));
  expect_valid(flat);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_LT(glm::length(flat.normals[i] - glm::vec3(0, 0, 1)), 1e-6f);
    EXPECT_LT(glm::length(flat.tangents[i] - glm::vec4(1, 0, 0, -1)), 1e-6f);
    EXPECT_EQ(flat.uv1[i], glm::vec2(0.0f));
    EXPECT_EQ(flat.colors[i], glm::vec4(1.0f));
  }
}

/// Two faces of a roof with areas 1 : 3 meet at an edge: the normal there leans towards the larger.
TEST(Flatten, WeighsNormalsByArea) {
  Primitive roof;
  roof.positions = {{0, 0, 0}, {0, 0, 1}, {1, 0, 0}, {0, 3, 0}};
  roof.indices = {0, 1, 2, 0, 3, 1};  // normal +y with area 1/2, normal +x with area 3/2
  const FlatGeometry flat = flatten(scene_of(roof));
  EXPECT_LT(glm::length(flat.normals[0] - glm::normalize(glm::vec3(3, 1, 0))), 1e-6f);
  EXPECT_LT(glm::length(flat.normals[2] - glm::vec3(0, 1, 0)), 1e-6f);
  expect_valid(flat);
}

TEST(Flatten, RewindsMirroredInstances) {
  for (const bool with_normals : {false, true}) {
    Primitive primitive = quad();
    if (with_normals) primitive.normals.assign(4, glm::vec3(0, 0, 1));
    const FlatGeometry flat = flatten(scene_of(primitive, glm::scale(glm::mat4(1.0f), glm::vec3(-2, 1, 1))));
    EXPECT_LT(glm::length(face_normal(flat, 0) - glm::vec3(0, 0, 1)), 1e-6f);
    EXPECT_LT(glm::length(flat.normals[0] - glm::vec3(0, 0, 1)), 1e-6f);
    // u now grows towards -x; bitangent = w cross(n, t) must still point to the texture's top, along -y.
    const glm::vec3 bitangent = flat.tangents[0].w * glm::cross(flat.normals[0], glm::vec3(flat.tangents[0]));
    EXPECT_LT(glm::length(glm::vec3(flat.tangents[0]) - glm::vec3(-1, 0, 0)), 1e-6f);
    EXPECT_LT(glm::length(bitangent - glm::vec3(0, -1, 0)), 1e-6f);
  }
}

/// KHR_texture_transform: the coordinates that tangents are computed from are the transformed ones. Tangents of the
/// file stay as they are.
TEST(Flatten, TangentsFollowTheTransformOfTheNormalTexture) {
  const auto with = [](const TextureRef& ref, bool given) {
    Primitive primitive = quad();
    primitive.material = 0;
    if (given) primitive.tangents.assign(4, glm::vec4(1, 0, 0, 1));
    Scene scene = scene_of(primitive);
    scene.materials.emplace_back().normal_texture = ref;
    return flatten(scene);
  };
  TextureRef turned;
  turned.image = 0;
  turned.rotation_rad = 0.7f;
  turned.scale = {2.0f, 0.5f};
  const FlatGeometry found = with(turned, false);
  expect_valid(found);
  // The same coordinates, transformed by hand.
  Primitive plain = quad();
  const float c = std::cos(0.7f), s = std::sin(0.7f);
  for (glm::vec2& uv : plain.uvs[0]) uv = {c * 2.0f * uv.x + s * 0.5f * uv.y, -s * 2.0f * uv.x + c * 0.5f * uv.y};
  const FlatGeometry expected = flatten(scene_of(plain));
  for (std::size_t i = 0; i < 4; ++i) EXPECT_LT(glm::length(found.tangents[i] - expected.tangents[i]), 1e-6f);
  EXPECT_GT(glm::length(found.tangents[0] - flatten(scene_of(quad())).tangents[0]), 0.1f);
  EXPECT_LT(glm::length(with(turned, true).tangents[0] - glm::vec4(1, 0, 0, 2)), 1e-6f);
}

/// glTF 2.0, 3.7.2.1: tangents belong to the texture coordinates of the normal texture; the green of a normal map is
/// up, where v falls (3.9.3).
TEST(Flatten, TakesTangentsFromTheSetOfTheNormalTexture) {
  Primitive primitive = quad();
  primitive.uvs[1] = {{0, 0}, {0, 1}, {-1, 1}, {-1, 0}};  // u along -y, v along x
  primitive.material = 0;
  Scene scene = scene_of(primitive);
  scene.materials.resize(2);
  EXPECT_LT(glm::length(flatten(scene).tangents[0] - glm::vec4(1, 0, 0, -1)), 1e-6f);
  scene.materials[0].normal_texture.image = 0;
  EXPECT_LT(glm::length(flatten(scene).tangents[0] - glm::vec4(1, 0, 0, -1)), 1e-6f);
  scene.materials[0].normal_texture.uv_set = 1;
  EXPECT_LT(glm::length(flatten(scene).tangents[0] - glm::vec4(0, -1, 0, -1)), 1e-6f);
  scene.materials[0] = Material();
  scene.materials[1].clearcoat_normal_texture.image = 0;
  scene.materials[1].clearcoat_normal_texture.uv_set = 1;
  scene.meshes[0].primitives[0].variant_materials[0] = 1;
  EXPECT_LT(glm::length(flatten(scene).tangents[0] - glm::vec4(0, -1, 0, -1)), 1e-6f);
  scene.meshes[0].primitives[0].uvs[0].clear();  // the second set alone
  EXPECT_LT(glm::length(flatten(scene).tangents[0] - glm::vec4(0, -1, 0, -1)), 1e-6f);
}

TEST(Flatten, MirrorsGivenTangents) {
  Primitive primitive = quad();
  primitive.normals.assign(4, glm::vec3(0, 0, 1));
  primitive.tangents.assign(4, glm::vec4(1, 0, 0, 1));
  const FlatGeometry flat = flatten(scene_of(primitive, glm::scale(glm::mat4(1.0f), glm::vec3(1, -1, 1))));
  const glm::vec3 bitangent = flat.tangents[0].w * glm::cross(flat.normals[0], glm::vec3(flat.tangents[0]));
  EXPECT_LT(glm::length(bitangent - glm::vec3(0, -2, 0)), 1e-6f);  // 2: of the file
}

/// Under a non-uniform scale normals follow the inverse transpose: still perpendicular to the surface.
TEST(Flatten, TransformsNormalsUnderNonUniformScale) {
  Primitive slope;
  slope.positions = {{0, 0, 0}, {1, 1, 0}, {0, 0, -1}};
  slope.indices = {0, 1, 2};
  slope.normals.assign(3, glm::normalize(glm::vec3(-1, 1, 0)));
  const FlatGeometry flat = flatten(scene_of(slope, glm::scale(glm::mat4(1.0f), glm::vec3(4, 1, 1))));
  EXPECT_LT(glm::length(flat.normals[0] - face_normal(flat, 0)), 1e-6f);
}

TEST(Flatten, StaysFiniteAtExtremeScalesAndForDegenerateTriangles) {
  for (const float scale : {1e-6f, 1.0f, 1e6f}) {
    Primitive primitive = quad();
    primitive.positions.push_back({2, 2, 0});  // belongs only to a triangle without area
    primitive.uvs[0].push_back({0.5f, 0.5f});
    primitive.indices.insert(primitive.indices.end(), {4, 4, 4});
    const FlatGeometry flat = flatten(scene_of(primitive, glm::scale(glm::mat4(1.0f), glm::vec3(scale))));
    expect_valid(flat);
    EXPECT_LT(glm::length(flat.normals[0] - glm::vec3(0, 0, 1)), 1e-6f);
    EXPECT_LT(glm::length(flat.tangents[0] - glm::vec4(1, 0, 0, -1)), 1e-6f);
  }
  expect_valid(flatten(scene_of(quad(), glm::mat4(0.0f))));  // scaled to nothing
}

TEST(Flatten, ListsInstancesAndPatchesAndSkipsTheHidden) {
  Scene scene = scene_of(quad());
  scene.patches.emplace_back();
  for (std::size_t i = 0; i < 16; ++i)
    scene.patches[0].points[i] = glm::vec3(static_cast<float>(i % 4), 0.0f, -static_cast<float>(i / 4));
  scene.nodes.resize(4);
  scene.nodes[1].mesh = 0;
  scene.nodes[1].parent = 0;
  scene.nodes[1].local = glm::translate(glm::mat4(1.0f), glm::vec3(0, 0, 5));
  scene.nodes[0].children = {1};
  scene.nodes[2].patch = 0;
  scene.nodes[3].mesh = 0;
  scene.nodes[3].visible = false;
  scene.roots = {0, 2, 3};
  const FlatGeometry flat = flatten(scene);
  ASSERT_EQ(flat.items.size(), 3u);
  EXPECT_EQ(flat.items[1].first_vertex, 4u);
  EXPECT_EQ(flat.items[1].first_index, 6u);
  EXPECT_EQ(flat.positions[4], glm::vec3(0, 0, 5));
  EXPECT_EQ(flat.items[2].patch, 0);
  EXPECT_EQ(flat.items[2].mesh, -1);
  EXPECT_EQ(flat.items[2].vertex_count, 17u * 17u);
  EXPECT_EQ(flat.items[2].index_count, 6u * 16u * 16u);
  for (std::size_t i = flat.items[2].first_index; i < flat.indices.size(); ++i) EXPECT_GE(flat.indices[i], 8u);
  EXPECT_TRUE(flatten(Scene{}).positions.empty());
}

/// Refused before memory for it is asked for.
TEST(Flatten, InstancesOfTooMuchAreRefused) {
  Scene scene;
  scene.materials = {test::matte(glm::vec3(0.5f))};
  test::add(&scene, test::make_grid({0, 0, 0}, {1, 0, 0}, {0, 1, 0}, 200, 0), "plate");
  Node again = scene.nodes.front();
  for (int i = 0; i < 1000; ++i) {
    scene.roots.push_back(static_cast<int>(scene.nodes.size()));
    scene.nodes.push_back(again);
  }
  EXPECT_THROW(flatten(scene), Error);
}

}  // namespace
}  // namespace maquette
