#include <gtest/gtest.h>

#include <filesystem>

#include "scenes/scene.h"
#include "test_paths.h"

namespace maquette {
namespace {

/// The real car, if present beside the checkout: Draco streams in 51 primitives.
TEST(Ferrari, LoadsWholeFromDraco) {
  const std::filesystem::path path =
      std::filesystem::path(MAQUETTE_SOURCE_DIR) / "../shared/data/scenes/ferrari458.glb";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << path << " is not there";
  const Scene scene = load_scene(path.string());
  EXPECT_EQ(count_triangles(scene), 358788u);
  EXPECT_EQ(scene.materials.size(), 17u);
  EXPECT_EQ(scene.meshes.size(), 51u);
  EXPECT_EQ(scene.materials[14].name, "Body_Color");
  const Bounds bounds = compute_bounds(scene);
  const glm::vec3 size = bounds.max - bounds.min;
  EXPECT_NEAR(size.z, 4.53f, 0.02f);  // the real car: 4.527 m long
  EXPECT_NEAR(size.y, 1.21f, 0.04f);  // 1.213 m high
  EXPECT_NEAR(bounds.min.y, 0.0f, 1e-3f);
  for (const Mesh& mesh : scene.meshes)
    for (const Primitive& primitive : mesh.primitives) EXPECT_EQ(primitive.normals.size(), primitive.positions.size());
}

}  // namespace
}  // namespace maquette
