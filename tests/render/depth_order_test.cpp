#include "render/glass/depth_order.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <random>

namespace maquette {
namespace {

using Triangle = std::array<std::uint32_t, 3>;

std::vector<Triangle> triangles_of(const std::vector<std::uint32_t>& indices) {
  std::vector<Triangle> triangles;
  for (std::size_t i = 0; i < indices.size(); i += 3) triangles.push_back({indices[i], indices[i + 1], indices[i + 2]});
  return triangles;
}

TEST(DepthOrder, SortsTheSameTrianglesByTheirDistance) {
  std::mt19937 random(3);
  std::uniform_real_distribution<float> place(-1.0f, 1.0f);
  const glm::vec3 eye(0.3f, -0.2f, 0.5f);
  std::vector<glm::vec3> positions(120);
  for (glm::vec3& p : positions) p = {place(random), place(random), place(random)};
  std::vector<std::uint32_t> indices;
  for (int i = 0; i < 600; ++i) indices.push_back(static_cast<std::uint32_t>(random() % positions.size()));
  const std::vector<std::uint32_t> sorted = back_to_front(positions, indices, eye);
  std::vector<Triangle> before = triangles_of(indices), after = triangles_of(sorted);
  const auto distance = [&](const Triangle& t) {
    return glm::length((glm::dvec3(positions[t[0]]) + glm::dvec3(positions[t[1]]) + glm::dvec3(positions[t[2]])) / 3.0 -
                       glm::dvec3(eye));
  };
  for (std::size_t i = 1; i < after.size(); ++i) EXPECT_LE(distance(after[i]), distance(after[i - 1]) + 1e-6);
  std::sort(before.begin(), before.end());
  std::sort(after.begin(), after.end());
  EXPECT_EQ(before, after);
  EXPECT_TRUE(back_to_front(positions, {}, eye).empty());
}

TEST(DepthOrder, OnlyFromOutsideATetrahedronFacesBothWays) {
  const std::vector<glm::vec3> positions{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
  const std::vector<std::uint32_t> solid{0, 2, 1, 0, 1, 3, 0, 3, 2, 1, 2, 3}, side{1, 2, 3};
  EXPECT_FALSE(faces_both_ways(positions, solid, {0.2f, 0.2f, 0.2f}));
  EXPECT_TRUE(faces_both_ways(positions, solid, {3.0f, 3.0f, 3.0f}));
  EXPECT_FALSE(faces_both_ways(positions, side, {3.0f, 3.0f, 3.0f}));
  EXPECT_FALSE(faces_both_ways(positions, {}, {3.0f, 3.0f, 3.0f}));
}

}  // namespace
}  // namespace maquette
