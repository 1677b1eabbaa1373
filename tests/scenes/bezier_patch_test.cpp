#include <gtest/gtest.h>

#include <random>

#include "scenes/subdivision.h"

namespace maquette {
namespace {

/// De Casteljau's construction: shares no polynomial with the code under test.
glm::dvec3 casteljau(std::array<glm::dvec3, 4> p, double t) {
  for (std::size_t last = 3; last > 0; --last)
    for (std::size_t i = 0; i < last; ++i) p[i] = (1.0 - t) * p[i] + t * p[i + 1];
  return p[0];
}

glm::dvec3 point_of(const BezierPatch& patch, double u, double v) {
  std::array<glm::dvec3, 4> column{};
  for (std::size_t row = 0; row < 4; ++row) {
    std::array<glm::dvec3, 4> points{};
    for (std::size_t i = 0; i < 4; ++i) points[i] = glm::dvec3(patch.points[4 * row + i]);
    column[row] = casteljau(points, u);
  }
  return casteljau(column, v);
}

BezierPatch bumpy_patch(std::uint32_t seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> offset(-0.2f, 0.2f);
  BezierPatch patch;
  for (std::size_t i = 0; i < 16; ++i)
    patch.points[i] =
        glm::vec3(static_cast<float>(i % 4) + offset(random), 3.0f * offset(random), -static_cast<float>(i / 4));
  return patch;
}

TEST(BezierPatch, MatchesDeCasteljau) {
  for (std::uint32_t seed = 0; seed < 5; ++seed) {
    const BezierPatch patch = bumpy_patch(seed);
    const int n = 9;
    const Primitive mesh = tessellate_patch(patch, n);
    ASSERT_EQ(mesh.positions.size(), 100u);
    for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
      const double u = static_cast<double>(i % 10) / n, v = static_cast<double>(i / 10) / n;
      EXPECT_LT(glm::length(glm::dvec3(mesh.positions[i]) - point_of(patch, u, v)), 1e-6);
      const double h = 1e-5;
      const glm::dvec3 along_u = point_of(patch, u + h, v) - point_of(patch, u - h, v);
      const glm::dvec3 along_v = point_of(patch, u, v + h) - point_of(patch, u, v - h);
      EXPECT_LT(glm::length(glm::dvec3(mesh.normals[i]) - glm::normalize(glm::cross(along_u, along_v))), 1e-6);
      EXPECT_EQ(mesh.uvs[0][i], glm::vec2(u, v));
    }
  }
}

TEST(BezierPatch, SidesFollowTheCurvature) {
  const PatchSides plane = patch_sides(BezierPatch{});
  EXPECT_EQ(plane.u, 16);
  EXPECT_EQ(plane.v, 16);
  for (std::uint32_t seed = 0; seed < 5; ++seed) {
    const PatchSides sides = patch_sides(bumpy_patch(seed));
    EXPECT_EQ(sides.u, 128);
    EXPECT_EQ(sides.v, 128);
  }
}

/// Curved by 0.3 rad from one edge to the other, and straight across: each direction gets the quads that it needs.
TEST(BezierPatch, EachSideHasItsOwnCount) {
  BezierPatch bent, other;  // along u, along v
  for (std::size_t i = 0; i < 16; ++i) {
    const auto u = static_cast<float>(i % 4) / 3.0f;
    bent.points[i] = glm::vec3(u, 0.15f * u * u, -static_cast<float>(i / 4));
    other.points[i % 4 * 4 + i / 4] = bent.points[i];
  }
  const PatchSides sides = patch_sides(bent), turned = patch_sides(other);
  EXPECT_GT(sides.u, 16);
  EXPECT_LT(sides.u, 128);
  EXPECT_EQ(sides.v, 16);
  EXPECT_EQ(turned.u, sides.v);
  EXPECT_EQ(turned.v, sides.u);
  const Primitive mesh = tessellate_patch(bent, sides);
  const auto columns = static_cast<std::size_t>(sides.u), rows = static_cast<std::size_t>(sides.v);
  ASSERT_EQ(mesh.positions.size(), (columns + 1) * (rows + 1));
  ASSERT_EQ(mesh.indices.size(), columns * rows * 6);
  const auto turn = [&](std::size_t a, std::size_t b) {
    return std::acos(std::min(glm::dot(mesh.normals[a], mesh.normals[b]), 1.0f));
  };
  for (std::size_t i = 0; i + columns + 1 < mesh.normals.size(); ++i) {
    EXPECT_LT(turn(i, i + columns + 1), 0.008f);
    if (i % (columns + 1) < columns) {
      EXPECT_LT(turn(i, i + 1), 0.008f);
    }
  }
  // Every corner is the patch's own point, and every triangle joins neighbours of the grid.
  for (std::size_t i = 0; i < mesh.positions.size(); ++i) {
    const double u = static_cast<double>(i % (columns + 1)) / static_cast<double>(columns);
    const double v = static_cast<double>(i / (columns + 1)) / static_cast<double>(rows);
    EXPECT_LT(glm::length(glm::dvec3(mesh.positions[i]) - point_of(bent, u, v)), 1e-6);
    EXPECT_EQ(mesh.uvs[0][i], glm::vec2(u, v));
  }
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const std::size_t low = std::min({mesh.indices[i], mesh.indices[i + 1], mesh.indices[i + 2]});
    for (std::size_t k = 0; k < 3; ++k) {
      const std::size_t step = mesh.indices[i + k] - low;
      EXPECT_TRUE(step <= 1 || step == columns + 1 || step == columns + 2) << step;
    }
  }
}

TEST(BezierPatch, TrianglesFaceAlongTheNormals) {
  const Primitive mesh = tessellate_patch(bumpy_patch(7), 12);
  ASSERT_EQ(mesh.indices.size(), 12u * 12u * 6u);
  for (std::size_t i = 0; i < mesh.indices.size(); i += 3) {
    const glm::vec3& a = mesh.positions[mesh.indices[i]];
    const glm::vec3 cross =
        glm::cross(mesh.positions[mesh.indices[i + 1]] - a, mesh.positions[mesh.indices[i + 2]] - a);
    EXPECT_GT(glm::dot(cross, mesh.normals[mesh.indices[i]]), 0.0f);
  }
}

/// One edge collapsed to a point, as at the pole of a dome: du vanishes there, but the normal must not.
TEST(BezierPatch, KeepsANormalAtACollapsedEdge) {
  BezierPatch patch = bumpy_patch(3);
  for (std::size_t i = 0; i < 4; ++i) patch.points[i] = glm::vec3(1.5f, 0.0f, 1.0f);
  const Primitive mesh = tessellate_patch(patch, 8);
  for (const glm::vec3& normal : mesh.normals) EXPECT_NEAR(glm::length(normal), 1.0f, 1e-5f);
  EXPECT_GT(glm::dot(mesh.normals[4], mesh.normals[9 + 4]), 0.8f);
}

TEST(BezierPatch, ADegeneratePatchIsStillValid) {
  const Primitive mesh = tessellate_patch(BezierPatch{}, 0);
  ASSERT_EQ(mesh.positions.size(), 4u);
  for (const glm::vec3& normal : mesh.normals) EXPECT_EQ(normal, glm::vec3(0.0f, 1.0f, 0.0f));
}

}  // namespace
}  // namespace maquette
