// What finer cells improve, and the visibility of cells that need none.
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "render/octree/octree_clip.h"
#include "render/octree/octree_kind.h"
#include "render/octree/octree_shared.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

Octree build(const Scene& scene, int depth, int detail) {
  OctreeJob job = make_octree_job(scene, scene.materials, -1, depth);
  job.options.detail = detail;
  return build_octree({job.geometry, job.materials, job.transmits, *job.textures}, job.options);
}

shared::OctreeRay ray_towards(const glm::vec3& origin, const glm::vec3& direction) {
  shared::OctreeRay ray{};
  ray.origin = origin;
  ray.direction = direction;
  ray.t_max = 100.0f;
  return ray;
}

float even_cell_m(const Octree& octree) {
  return octree.side_m / std::exp2(static_cast<float>(octree.depth - octree.detail));
}

/// Compares with counting the points of a fine grid on a face whose plane above or below them is inside the cube.
TEST(OctreeClip, PlaneSectionsHaveTheirArea) {
  EXPECT_DOUBLE_EQ(plane_section_area({0, 2, 0}, {0.3, 1.2, 9.0}, {0, 1, 0}, 1.0), 1.0);
  EXPECT_DOUBLE_EQ(plane_section_area({0, 2, 0}, {0.3, 2.2, 9.0}, {0, 1, 0}, 1.0), 0.0);
  EXPECT_NEAR(plane_section_area({1, -1, 0}, {3, 3, 3}, {2, 2, 2}, 2.0), 4.0 * std::sqrt(2.0), 1e-12);
  EXPECT_NEAR(plane_section_area({1, 1, 1}, {0.5, 0.5, 0.5}, {0, 0, 0}, 1.0), 0.75 * std::sqrt(3.0), 1e-12);
  std::mt19937 random(4);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  for (int i = 0; i < 50; ++i) {
    const glm::dvec3 n = glm::normalize(glm::dvec3(u(random), u(random), u(random))),
                     p(u(random), u(random), u(random));
    const int axis = std::abs(n.x) > std::abs(n.y) ? (std::abs(n.x) > std::abs(n.z) ? 0 : 2)
                                                   : (std::abs(n.y) > std::abs(n.z) ? 1 : 2);
    constexpr int kSide = 400;
    int inside = 0;
    for (int k = 0; k < kSide * kSide; ++k) {
      glm::dvec3 q(0.0);
      q[(axis + 1) % 3] = 2.0 * (k % kSide + 0.5) / kSide - 1.0;
      q[(axis + 2) % 3] = 2.0 * (k / kSide + 0.5) / kSide - 1.0;
      inside += std::abs(glm::dot(n, p - q) / n[axis]) <= 1.0;
    }
    const double expected = 4.0 * inside / (kSide * kSide) / std::abs(n[axis]);
    EXPECT_NEAR(plane_section_area(3.0 * n, p, {-1, -1, -1}, 2.0), expected, 0.05) << i;
  }
}

/// A cell's plane extends through all of the cell: where the surface ends, it must not extend far beyond. (At most half
/// of a brick's cells are split, so a few of a tip's cells stay coarse.)
TEST(OctreeDetail, SurfacesEndWhereTheyEnd) {
  Primitive triangle;
  triangle.material = 0;
  triangle.positions = {{0.0f, 0.1f, 0.0f}, {1.0f, 0.13f, 0.3f}, {0.2f, 0.16f, 0.9f}};
  triangle.indices = {0, 2, 1};
  Scene scene;
  scene.materials.emplace_back();
  test::add(&scene, triangle, "triangle");
  const auto outside_m = [&](const glm::vec3& p) {  // distance to the nearest of the edges, seen from above
    float most = -1e9f;
    for (std::size_t k = 0; k < 3; ++k) {
      const glm::vec3 a = triangle.positions[k], d = triangle.positions[(k + 1) % 3] - a, q = p - a;
      most = std::max(most, (q.x * d.z - q.z * d.x) / std::hypot(d.x, d.z));
    }
    return most;
  };
  int far[2] = {};
  for (const int detail : {0, 2}) {
    const Octree octree = build(scene, 7, detail);
    shared::octree_view = {octree.words.data(), octree.planes.data(), octree.colors.data()};
    const float cell_m = even_cell_m(octree);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> u(-0.1f, 1.1f);
    for (int i = 0; i < 100000; ++i) {
      const auto ray = ray_towards({u(random), 1.0f, u(random)}, {0.0f, -1.0f, 0.0f});
      const bool met = shared::octree_trace(shared::octree_frame(octree), ray).node >= 0;
      const float outside = outside_m(ray.origin);
      EXPECT_TRUE(met || outside > -0.01f * cell_m) << ray.origin.x << " " << ray.origin.z;
      far[detail / 2] += met && outside > 0.4f * cell_m;
    }
  }
  EXPECT_GT(far[0], 100);
  EXPECT_LT(far[1], far[0] / 20);
}

/// Behind a sheet is another material, closer to the centres of many cells than the sheet that hides it.
TEST(OctreeSurface, WhatIsHiddenStaysHidden) {
  Scene scene;
  scene.materials.resize(2);
  test::add(&scene, test::make_grid({0.0f, 0.10f, 0.0f}, {0.0f, 0.0f, 1.0f}, {1.0f, 0.06f, 0.0f}, 1, 0), "seen");
  test::add(&scene, test::make_grid({0.0f, 0.075f, 0.0f}, {0.0f, 0.0f, 1.0f}, {1.0f, 0.06f, 0.0f}, 1, 1), "hidden");
  const Octree octree = build(scene, 5, 2);
  shared::octree_view = {octree.words.data(), octree.planes.data(), octree.colors.data()};
  std::size_t wrong = 0, wrong_without = 0;
  std::mt19937 random(3);
  std::uniform_real_distribution<float> u(0.05f, 0.95f);
  for (int i = 0; i < 20000; ++i) {
    const auto ray = ray_towards({u(random), 1.0f, u(random)}, {0.0f, -1.0f, 0.0f});
    auto frame = shared::octree_frame(octree);
    const auto hit = shared::octree_trace(frame, ray);
    ASSERT_GE(hit.node, 0);
    const glm::vec3 at = ray.origin + hit.t * ray.direction;
    wrong += shared::octree_surface(frame, hit, at, ray.direction).material != 0;
    frame.detail = 0;  // with that, a cell may hold more than its own material
    wrong_without += shared::octree_surface(frame, hit, at, ray.direction).material != 0;
  }
  EXPECT_EQ(wrong, 0u);
  EXPECT_GT(wrong_without, 100u);
}

/// At the silhouette of a tube cells face away, but are not back faces; a sheet seen from behind shows its back face.
TEST(OctreeSurface, SilhouettesAreNotBackFaces) {
  Primitive tube;
  tube.material = 0;
  constexpr int kSides = 96;
  for (int i = 0; i <= kSides; ++i) {
    const float angle = 6.2831853f * static_cast<float>(i) / kSides;
    for (const float z : {0.0f, 1.0f}) {
      tube.positions.emplace_back(0.11f * std::cos(angle), 0.11f * std::sin(angle), z);
      tube.normals.emplace_back(std::cos(angle), std::sin(angle), 0.0f);
    }
    const auto a = static_cast<std::uint32_t>(2 * i);
    if (i < kSides) tube.indices.insert(tube.indices.end(), {a, a + 2, a + 1, a + 1, a + 2, a + 3});
  }
  Scene scene;
  scene.materials.emplace_back();
  test::add(&scene, tube, "tube");
  test::add(&scene, test::make_grid({0.5f, 0.0f, 0.0f}, {0.0f, 0.0f, 1.0f}, {0.5f, 0.0f, 0.0f}, 1, 0), "sheet");
  for (const int detail : {0, 2}) {
    const Octree octree = build(scene, 5, detail);
    shared::octree_view = {octree.words.data(), octree.planes.data(), octree.colors.data()};
    const auto frame = shared::octree_frame(octree);
    std::mt19937 random(3);
    std::uniform_real_distribution<float> u(-0.2f, 0.2f), along(0.1f, 0.9f);
    std::size_t rims = 0, backs = 0;
    for (int i = 0; i < 20000; ++i) {
      const auto ray = ray_towards({u(random), 2.0f, along(random)}, {0.0f, -1.0f, 0.0f});
      const auto hit = shared::octree_trace(frame, ray);
      if (hit.node < 0) continue;
      const glm::vec3 at = ray.origin + hit.t * ray.direction;
      const glm::vec3 out = glm::normalize(glm::vec3(at.x, at.y, 0.0f));
      rims += out.y < 0.1f;
      backs += glm::dot(shared::octree_surface(frame, hit, at, ray.direction).normal, out) < 0.0f;
    }
    EXPECT_GT(rims, 50u);
    EXPECT_EQ(backs, 0u);
    const auto below = ray_towards({0.75f, -1.0f, 0.5f}, {0.0f, 1.0f, 0.0f});
    const auto hit = shared::octree_trace(frame, below);
    ASSERT_GE(hit.node, 0);
    const glm::vec3 at = below.origin + hit.t * below.direction;
    EXPECT_LT(shared::octree_surface(frame, hit, at, below.direction).normal.y, -0.9f);
  }
}

/// From the node where the paths to eight neighbours separate, traversal ends at the same nodes as from the root; also
/// outside the tree.
TEST(OctreeSurface, NeighboursShareTheirTraversal) {
  Scene scene = build_builtin_scene("sphere");
  test::add(&scene, test::make_grid({-2, -1.3f, -2}, {4, 0, 0}, {0, 0.1f, 4}, 8, 0), "board");
  const Octree octree = build(scene, 5, 2);
  shared::octree_view = {octree.words.data(), octree.planes.data(), octree.colors.data()};
  std::size_t wrong = 0, found = 0, coarser = 0;
  for (int level = 0; level <= octree.depth; ++level) {
    const int side = (1 << level) + 1;
    for (int k = 0; k < side * side * side; ++k) {
      const glm::ivec3 lowest = glm::ivec3(k % side, k / side % side, k / side / side) - 1;
      const shared::OctreeDescent common = shared::octree_common(lowest, level);
      for (int c = 0; c < 8; ++c) {
        const glm::ivec3 cell = lowest + glm::ivec3(c & 1, c >> 1 & 1, c >> 2);
        const auto expected = shared::octree_node_at(shared::octree_root(level), cell, level);
        const auto at = shared::octree_node_at(common, cell, level);
        wrong += at.node != expected.node || (at.node >= 0 && at.level != expected.level);
        found += at.node >= 0;
        coarser += at.node >= 0 && at.level < level;
      }
    }
  }
  EXPECT_EQ(wrong, 0u);
  EXPECT_GT(found, 1000u);
  EXPECT_GT(coarser, 100u);
}

}  // namespace
}  // namespace maquette
