#include "render/reflections/coarse_patches.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <random>

namespace maquette {
namespace {

/// A patch like a windshield, in a node of this transform.
FlatGeometry curved_pane(const glm::mat4& world) {
  Scene scene;
  BezierPatch patch;
  for (int j = 0; j < 4; ++j)
    for (int i = 0; i < 4; ++i) {
      const float x = static_cast<float>(i) / 3.0f - 0.5f, y = static_cast<float>(j) / 3.0f - 0.5f;
      patch.points[static_cast<std::size_t>(4 * j + i)] = {1.4f * x * (1.0f + 0.2f * y), 0.8f * y,
                                                           0.5f * x * x * x + 0.3f * y * y};
    }
  scene.patches.push_back(patch);
  Node node;
  node.patch = 0;
  node.local = world;
  scene.nodes.push_back(node);
  scene.roots.push_back(0);
  return flatten(scene);
}

const glm::mat4 kTurned = glm::mat4(0.8f, 0.6f, 0, 0, -0.6f, 0.8f, 0, 0, 0, 0, 1, 0, 0.1f, 1.0f, -0.4f, 1);
const glm::mat4 kMirrored = glm::mat4(-1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 0.3f, 0, 0, 1);

/// Source: Ericson 2005, "Real-Time Collision Detection", Sec. 5.1.5.
float distance_to_triangle(const glm::vec3& p, const glm::vec3& a, const glm::vec3& b, const glm::vec3& c) {
  const glm::vec3 ab = b - a, ac = c - a, ap = p - a, bp = p - b, cp = p - c;
  const float d1 = glm::dot(ab, ap), d2 = glm::dot(ac, ap), d3 = glm::dot(ab, bp), d4 = glm::dot(ac, bp),
              d5 = glm::dot(ab, cp), d6 = glm::dot(ac, cp);
  if (d1 <= 0.0f && d2 <= 0.0f) return glm::length(ap);
  if (d3 >= 0.0f && d4 <= d3) return glm::length(bp);
  if (d6 >= 0.0f && d5 <= d6) return glm::length(cp);
  const float va = d3 * d6 - d5 * d4, vb = d5 * d2 - d1 * d6, vc = d1 * d4 - d3 * d2;
  if (vc <= 0.0f && d1 >= 0.0f && d3 <= 0.0f) return glm::length(p - (a + ab * (d1 / (d1 - d3))));
  if (vb <= 0.0f && d2 >= 0.0f && d6 <= 0.0f) return glm::length(p - (a + ac * (d2 / (d2 - d6))));
  if (va <= 0.0f && d4 >= d3 && d5 >= d6) return glm::length(p - (b + (c - b) * ((d4 - d3) / ((d4 - d3) + (d5 - d6)))));
  const float sum = va + vb + vc;
  return glm::length(p - (a + ab * (vb / sum) + ac * (vc / sum)));
}

TEST(CoarsePatches, KnowTheTessellation) {
  for (const glm::mat4& world : {kTurned, kMirrored}) {
    const FlatGeometry g = curved_pane(world);
    const PatchSides sides = make_coarse_patches(g).of_item.at(0).sides;
    EXPECT_NE(sides.u, sides.v);
    EXPECT_EQ(static_cast<std::uint32_t>((sides.u + 1) * (sides.v + 1)), g.items[0].vertex_count);
    EXPECT_EQ(static_cast<std::uint32_t>(6 * sides.u * sides.v), g.items[0].index_count);
    // The last vertex of the first row, and the first of the second row.
    const auto last = static_cast<std::size_t>(sides.u);
    EXPECT_EQ(g.uv0[last], glm::vec2(1.0f, 0.0f));
    EXPECT_EQ(g.uv0[last + 1], glm::vec2(0.0f, 1.0f / static_cast<float>(sides.v)));
  }
}

TEST(CoarsePatches, NoVertexIsFartherThanTheLevelSays) {
  for (const glm::mat4& world : {kTurned, kMirrored}) {
    const FlatGeometry g = curved_pane(world);
    const CoarsePatches patches = make_coarse_patches(g);
    ASSERT_EQ(patches.of_item.size(), 1u);
    const CoarsePatch& patch = patches.of_item.at(0);
    ASSERT_EQ(patch.levels.size(), 4u);
    for (const CoarsePatch::Level& level : patch.levels) {
      SCOPED_TRACE(level.quads);
      float most = 0.0f;
      for (std::uint32_t v = 0; v < g.items[0].vertex_count; ++v) {
        float nearest = std::numeric_limits<float>::max();
        for (std::uint32_t k = 0; k < level.index_count; k += 3) {
          const std::uint32_t* t = patches.indices.data() + level.first_index + k;
          nearest = std::min(
              nearest, distance_to_triangle(g.positions[v], g.positions[t[0]], g.positions[t[1]], g.positions[t[2]]));
        }
        most = std::max(most, nearest);
      }
      EXPECT_LE(most, level.deviation_m + 1e-6f);
      EXPECT_GT(most, 0.1f * level.deviation_m);  // a useless bound would keep all triangles
    }
  }
}

/// Face culling depends on it.
TEST(CoarsePatches, AreWoundAsThePatch) {
  for (const glm::mat4& world : {kTurned, kMirrored}) {
    const FlatGeometry g = curved_pane(world);
    const CoarsePatches patches = make_coarse_patches(g);
    const auto facing = [&](const std::vector<std::uint32_t>& indices, std::size_t first) {
      const std::uint32_t* t = indices.data() + first;
      const glm::vec3 a = g.positions[t[0]], across = glm::cross(g.positions[t[1]] - a, g.positions[t[2]] - a);
      return glm::dot(across, g.normals[t[0]]) > 0.0f;
    };
    const bool outwards = facing(g.indices, 0);
    for (std::size_t first = 0; first < patches.indices.size(); first += 3)
      EXPECT_EQ(facing(patches.indices, first), outwards);
  }
}

TEST(CoarsePatches, TheLevelIsAsFineAsItsNearestVertexNeeds) {
  const FlatGeometry g = curved_pane(kTurned);
  const CoarsePatch patch = make_coarse_patches(g).of_item.at(0);
  std::mt19937 random(3);
  std::uniform_real_distribution<float> uniform(-1.0f, 1.0f), decades(-4.5f, -2.0f);
  int coarse = 0;
  for (int k = 0; k < 2000; ++k) {
    const glm::vec3 eye(2.0f * uniform(random), 1.0f + 2.0f * uniform(random), 2.0f * uniform(random));
    const float tolerance_rad = std::pow(10.0f, decades(random));
    const CoarsePatch::Level* level = coarsest_level(patch, eye, tolerance_rad);
    if (!level) continue;
    ++coarse;
    float nearest_m = std::numeric_limits<float>::max();
    for (const glm::vec3& p : g.positions) nearest_m = std::min(nearest_m, glm::length(p - eye));
    EXPECT_LE(level->deviation_m, tolerance_rad * nearest_m);
  }
  EXPECT_GT(coarse, 500);
  EXPECT_EQ(coarsest_level(patch, g.positions[0], 0.1f), nullptr);
  EXPECT_EQ(coarsest_level(patch, glm::vec3(0.0f, 1.0f, 50.0f), 0.01f)->quads, 16u);
}

}  // namespace
}  // namespace maquette
