#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <set>
#include <string>

#include "scenes/error.h"
#include "scenes/scene.h"

namespace maquette {
namespace {

class BuiltinScene : public testing::TestWithParam<const char*> {};

TEST_P(BuiltinScene, IndicesAndAttributesAreSound) {
  const Scene scene = build_builtin_scene(GetParam());
  EXPECT_EQ(scene.name, "builtin:" + std::string(GetParam()));
  EXPECT_FALSE(scene.cameras.empty());
  EXPECT_EQ(scene.roots.size(), scene.nodes.size());
  for (const Mesh& mesh : scene.meshes) {
    for (const Primitive& p : mesh.primitives) {
      ASSERT_FALSE(p.indices.empty()) << mesh.name;
      ASSERT_EQ(p.indices.size() % 3, 0u);
      ASSERT_EQ(p.normals.size(), p.positions.size()) << mesh.name;
      ASSERT_TRUE(p.uvs[0].empty() || p.uvs[0].size() == p.positions.size()) << mesh.name;
      ASSERT_GE(p.material, 0) << mesh.name;
      ASSERT_LT(p.material, static_cast<int>(scene.materials.size()));
      for (const std::uint32_t i : p.indices) ASSERT_LT(i, p.positions.size()) << mesh.name;
      for (std::size_t i = 0; i < p.positions.size(); ++i) {
        ASSERT_TRUE(std::isfinite(glm::dot(p.positions[i], p.positions[i]))) << mesh.name;
        ASSERT_NEAR(glm::length(p.normals[i]), 1.0f, 1e-3f) << mesh.name;
      }
    }
  }
}

TEST_P(BuiltinScene, NormalsAgreeWithTheWinding) {
  const Scene scene = build_builtin_scene(GetParam());
  for (const Mesh& mesh : scene.meshes) {
    for (const Primitive& p : mesh.primitives) {
      double agreeing = 0.0, total = 0.0;
      std::size_t degenerate = 0;
      for (std::size_t i = 0; i < p.indices.size(); i += 3) {
        const std::uint32_t a = p.indices[i], b = p.indices[i + 1], c = p.indices[i + 2];
        const glm::vec3 area = glm::cross(p.positions[b] - p.positions[a], p.positions[c] - p.positions[a]);
        const double size = glm::length(area);
        if (size < 1e-12) ++degenerate;
        total += size;
        if (glm::dot(area, p.normals[a] + p.normals[b] + p.normals[c]) > 0.0f) agreeing += size;
      }
      EXPECT_GT(agreeing, 0.998 * total) << mesh.name;
      EXPECT_LT(static_cast<double>(degenerate), 0.01 * static_cast<double>(p.indices.size() / 3) + 1.0) << mesh.name;
    }
  }
}

TEST_P(BuiltinScene, IsTheSameEveryTime) {
  const Scene a = build_builtin_scene(GetParam()), b = build_builtin_scene(GetParam());
  ASSERT_EQ(a.meshes.size(), b.meshes.size());
  for (std::size_t i = 0; i < a.meshes.size(); ++i) {
    ASSERT_EQ(a.meshes[i].primitives.size(), b.meshes[i].primitives.size());
    for (std::size_t j = 0; j < a.meshes[i].primitives.size(); ++j) {
      const Primitive &p = a.meshes[i].primitives[j], &q = b.meshes[i].primitives[j];
      ASSERT_EQ(p.positions.size(), q.positions.size());
      EXPECT_EQ(std::memcmp(p.positions.data(), q.positions.data(), p.positions.size() * sizeof(glm::vec3)), 0);
      EXPECT_EQ(p.indices, q.indices);
    }
  }
  ASSERT_EQ(a.images.size(), b.images.size());
  for (std::size_t i = 0; i < a.images.size(); ++i) EXPECT_EQ(a.images[i].rgba, b.images[i].rgba);
}

TEST_P(BuiltinScene, NamesAreUnique) {
  const Scene scene = build_builtin_scene(GetParam());
  std::set<std::string> names;
  for (const Material& material : scene.materials) EXPECT_TRUE(names.insert(material.name).second) << material.name;
  names.clear();
  for (const Node& node : scene.nodes) EXPECT_TRUE(names.insert(node.name).second) << node.name;
}

INSTANTIATE_TEST_SUITE_P(All, BuiltinScene, testing::Values("sphere", "plate", "cornell", "seat", "cockpit"),
                         [](const auto& instance) { return std::string(instance.param); });

TEST(BuiltinScenes, UnknownNameListsTheKnownOnes) {
  try {
    build_builtin_scene("car");
    FAIL();
  } catch (const UsageError& error) {
    EXPECT_NE(std::string(error.what()).find("sphere"), std::string::npos);
  }
}

TEST(BuiltinScenes, SphereIsAUnitSphereWithExactNormals) {
  const Scene scene = build_builtin_scene("sphere");
  ASSERT_EQ(scene.meshes.size(), 1u);
  const Primitive& p = scene.meshes[0].primitives[0];
  for (std::size_t i = 0; i < p.positions.size(); ++i) {
    ASSERT_NEAR(glm::length(p.positions[i]), 1.0f, 1e-6f);
    ASSERT_LT(glm::length(p.positions[i] - p.normals[i]), 1e-6f);
  }
  ASSERT_EQ(scene.materials.size(), 1u);
  EXPECT_EQ(scene.materials[0].name, "Sphere");
  EXPECT_EQ(scene.materials[0].measured, "builtin:paint-red-metallic");
}

TEST(BuiltinScenes, CornellLightFacesDown) {
  const Scene scene = build_builtin_scene("cornell");
  bool found = false;
  for (const Mesh& mesh : scene.meshes) {
    const Primitive& p = mesh.primitives[0];
    if (scene.materials[static_cast<std::size_t>(p.material)].emissive.x <= 0.0f) continue;
    found = true;
    for (const glm::vec3& normal : p.normals) EXPECT_LT(normal.y, -0.99f);
  }
  EXPECT_TRUE(found);
}

}  // namespace
}  // namespace maquette
