#include "render/reflections/clusters.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <random>
#include <set>

#include "scenes/scene.h"

namespace maquette {
namespace {

TEST(Clusters, HoldEveryTriangleOnceAndKeepTheirLimits) {
  const FlatGeometry geometry = flatten(load_scene("builtin:seat"));
  const ClusterSet set = make_clusters(geometry);
  ASSERT_EQ(set.of_item.size(), geometry.items.size());
  std::set<std::uint32_t> triangles;
  for (std::size_t i = 0; i < geometry.items.size(); ++i) {
    for (std::size_t k = set.of_item[i].begin; k < set.of_item[i].end; ++k) {
      const Cluster& c = set.clusters[k];
      EXPECT_LE(c.vertex_count, Cluster::kMaxVertices);
      EXPECT_LE(c.triangle_count, Cluster::kMaxTriangles);
      EXPECT_GT(c.triangle_count, 0u);
      for (std::uint32_t t = 0; t < c.triangle_count; ++t) {
        const std::uint32_t number = set.triangles[c.first_triangle + t].y;
        EXPECT_GE(3 * number, geometry.items[i].first_index);
        EXPECT_LT(3 * number, geometry.items[i].first_index + geometry.items[i].index_count);
        EXPECT_TRUE(triangles.insert(number).second);
        for (std::uint32_t corner = 0; corner < 3; ++corner) {
          const std::uint32_t local = set.triangles[c.first_triangle + t].x >> (8 * corner) & 255u;
          ASSERT_LT(local, c.vertex_count);
          const std::uint32_t vertex = set.vertices[c.first_vertex + local];
          EXPECT_EQ(vertex, geometry.indices[3 * number + corner]);
          EXPECT_LE(glm::length(geometry.positions[vertex] - c.center), c.radius * 1.0001f);
        }
      }
    }
  }
  EXPECT_EQ(triangles.size(), geometry.indices.size() / 3);
}

/// Spheres that a ray of the beam meets, near and far, with narrow and wide beams: none may be rejected.
TEST(Clusters, NoSphereIsMissedThatARayMeets) {
  std::mt19937 random(5);
  std::normal_distribution<float> normal;
  std::uniform_real_distribution<float> uniform;
  const auto vector = [&] { return glm::vec3(normal(random), normal(random), normal(random)); };
  int given_up = 0;
  for (int trial = 0; trial < 200000; ++trial) {
    const float spread = std::pow(10.0f, -4.0f + 4.5f * uniform(random)),
                size = std::pow(10.0f, -3.0f + 3.0f * uniform(random));
    const glm::vec3 middle = vector(), axis = glm::normalize(vector());
    std::array<glm::vec3, 3> origins{}, directions{};
    for (std::size_t k = 0; k < 3; ++k) {
      origins[k] = middle + size * vector();
      directions[k] = glm::normalize(axis + spread * vector());
    }
    const Beam beam = make_beam(origins, directions);
    glm::vec3 w(uniform(random), uniform(random), uniform(random));
    w /= w.x + w.y + w.z;
    const glm::vec3 origin = w.x * origins[0] + w.y * origins[1] + w.z * origins[2];
    const glm::vec3 sum = w.x * directions[0] + w.y * directions[1] + w.z * directions[2];
    const float distance = std::pow(10.0f, -3.0f + 5.0f * uniform(random)),
                radius = std::pow(10.0f, -3.0f + 3.0f * uniform(random));
    if (glm::length(sum) < 1e-3f) continue;
    const glm::vec3 center =
        origin + glm::normalize(sum) * distance + 0.999f * radius * uniform(random) * glm::normalize(vector());
    EXPECT_TRUE(may_meet(beam, center, radius)) << trial;
    given_up += !may_meet(beam, origin + vector() * 3.0f, radius);
  }
  EXPECT_GT(given_up, 20000);
}

}  // namespace
}  // namespace maquette
