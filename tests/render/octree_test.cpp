#include <gtest/gtest.h>

#include <algorithm>

#include "tests/render/octree_models.h"

namespace maquette {
namespace {

using namespace test;

TEST(OctreeClip, PiecesSumToTheWholeAndStayInTheirCells) {
  std::mt19937 random(1);
  std::uniform_real_distribution<double> u(0.0, 32.0);
  for (int i = 0; i < 200; ++i) {
    ClipPolygon polygon;
    polygon.count = 3;
    for (int k = 0; k < 3; ++k) polygon.corners[k] = {u(random), u(random), u(random)};
    if (i % 3 == 0)
      for (int k = 0; k < 3; ++k) polygon.corners[k][i % 9 / 3] = std::floor(polygon.corners[0][i % 9 / 3]);
    const glm::dvec3 whole = polygon_area_vector(polygon);
    glm::dvec3 sum(0.0), moment(0.0);
    const CellClipper::IsLeaf is_leaf = [](const glm::ivec3&, int level) { return level == 5; };
    const std::function<void(const CellClipper::Piece&)> emit = [&](const CellClipper::Piece& piece) {
      sum += polygon_area_vector(*piece.polygon);
      moment += polygon_centroid(*piece.polygon) * glm::length(polygon_area_vector(*piece.polygon));
      for (int k = 0; k < piece.polygon->count; ++k)
        for (int a = 0; a < 3; ++a) {
          EXPECT_GE(piece.polygon->corners[k][a], piece.lower[a] - 1e-9);
          EXPECT_LE(piece.polygon->corners[k][a], piece.lower[a] + 1 + 1e-9);
        }
    };
    CellClipper(5, is_leaf, emit).clip(polygon, glm::ivec3(0), 0);
    EXPECT_LT(glm::length(sum - whole), 1e-6 * glm::length(whole));
    const glm::dvec3 centroid = (polygon.corners[0] + polygon.corners[1] + polygon.corners[2]) / 3.0;
    EXPECT_LT(glm::length(moment / glm::length(whole) - centroid), 1e-6 * 32.0);
  }
}

TEST(OctreeBuild, KeepsTheAreaOfTheScene) {
  for (const char* name : {"sphere", "cornell", "seat"}) {
    const Model model(build_builtin_scene(name));
    OctreeOptions options;
    options.depth = 7;
    const auto bricks = build_octree_bricks(model.source(), options, nullptr, {});
    EXPECT_NEAR(total_area(*bricks) / model.area(), 1.0, 1e-5) << name;
  }
}

TEST(OctreeBuild, NormalsAndPlanesOfASphere) {
  const Model model(build_builtin_scene("sphere"));
  OctreeOptions options;
  options.depth = 6;
  const Octree octree = build_octree(model.source(), options);
  const double cell = static_cast<double>(octree.side_m) / 64.0;
  int planar = 0, all = 0;
  for (const OctreeCell& leaf : list_leaves(octree)) {
    const auto plane = exact::octree_unpack_plane(octree.words[leaf.node]);
    const glm::dvec3 center = glm::dvec3(octree.corner) + (glm::dvec3(leaf.coordinate) + 0.5) * cell;
    ++all;
    planar += plane.planar;
    if (!plane.planar) continue;
    const glm::dvec3 n = glm::normalize(plane.normal);
    EXPECT_GT(glm::dot(n, glm::normalize(center)), 0.995);
    // The foot of the perpendicular from the cell's centre lies on the unit sphere.
    const glm::dvec3 foot = center + cell * plane.normal * (plane.offset / glm::dot(plane.normal, plane.normal));
    EXPECT_NEAR(glm::length(foot), 1.0, 0.06 * cell + 1e-3);
  }
  EXPECT_GT(planar, all * 9 / 10);
}

TEST(OctreeBuild, TakesTheMaterialOfTheLargestArea) {
  const Octree octree = two_materials(0.4f, 0.4f, 3);
  ASSERT_FALSE(octree.empty());
  EXPECT_EQ(shared::octree_unpack_color(octree.colors[0]).material, 1);  // the root holds 0.4 and 0.6
  int counts[2] = {};
  for (const OctreeCell& leaf : list_leaves(octree))
    ++counts[shared::octree_unpack_color(octree.colors[leaf.node]).material];
  EXPECT_EQ(counts[0],
            3 * 8);  // of 8 columns of cells; the fourth, from 0.375 to 0.5, mostly belongs to the larger material
  EXPECT_EQ(counts[1], 5 * 8);
}

/// A screen of the size of its housing's face, a little in front of it: every cell shows the screen, in its own colour.
TEST(OctreeBuild, MaterialIsTheOneInFront) {
  const auto quad = [](float z, int material, float shade) {
    Primitive p;
    p.positions = {{0, 0, z}, {1, 0, z}, {1, 1, z}, {0, 1, z}};
    p.normals.assign(4, {0, 0, 1});
    p.colors.assign(4, glm::vec4(glm::vec3(shade), 1.0f));
    p.indices = {0, 1, 2, 0, 2, 3};
    p.material = material;
    return p;
  };
  Scene scene = scene_of(quad(0.0f, 0, 1.0f));
  scene.meshes[0].primitives.push_back(quad(0.001f, 1, 0.25f));
  scene.meshes[0].primitives.push_back(quad(0.9f, 1, 0.25f));  // so that no cell border lies between the two
  scene.materials.resize(2);
  const Model model(std::move(scene));
  OctreeOptions options;
  options.depth = 4;
  const Octree octree = build_octree(model.source(), options);
  const std::vector<OctreeCell> leaves = list_leaves(octree);
  ASSERT_FALSE(leaves.empty());
  for (const OctreeCell& leaf : leaves) {
    const shared::OctreeColor color = shared::octree_unpack_color(octree.colors[leaf.node]);
    EXPECT_EQ(color.material, 1);
    EXPECT_NEAR(color.tint.x, 0.25f, 0.02f);
  }
}

TEST(OctreeBuild, RegionsAreFinerThanTheRest) {
  const Model model(build_builtin_scene("sphere"));
  OctreeOptions options;
  options.depth = 7;
  options.interest = {{glm::vec3(0.5f, -2.0f, -2.0f), glm::vec3(2.0f)}};
  const Octree octree = build_octree(model.source(), options);
  std::size_t fine = 0, coarse = 0;
  for (const OctreeCell& leaf : list_leaves(octree)) {
    const float cell = octree.side_m / static_cast<float>(1 << leaf.level);
    const float high = octree.corner.x + cell * static_cast<float>(leaf.coordinate.x + 1);
    EXPECT_GE(leaf.level, 5);
    fine += leaf.level == 7;
    coarse += leaf.level == 5;
    if (leaf.level < 7) {
      EXPECT_LE(high, 0.5f + 1e-5f);
    }
  }
  EXPECT_GT(fine, 100u);
  EXPECT_GT(coarse, 100u);
}

TEST(OctreeBuild, CellsOfMuchDetailAreFiner) {
  const Model model(plates());
  OctreeOptions options;
  options.depth = 5;
  const Octree even = build_octree(model.source(), options);
  options.detail = 2;
  const auto bricks = build_octree_bricks(model.source(), options, nullptr, {});
  EXPECT_NEAR(total_area(*bricks) / model.area(), 1.0, 1e-5);
  const Octree octree = assemble_octree(*bricks);
  ASSERT_EQ(octree.depth, 7);
  ASSERT_EQ(octree.detail, 2);
  std::size_t fine = 0;
  const double cell = static_cast<double>(octree.side_m) / 32.0;
  for (const OctreeCell& leaf : list_leaves(octree)) {
    EXPECT_GE(leaf.level, 5);
    if (leaf.level == 5) continue;
    // At the corner, at the border of the materials, and along the stripe.
    const glm::dvec3 middle =
        glm::dvec3(octree.corner) + (glm::dvec3(leaf.coordinate) + 0.5) * std::exp2(5 - leaf.level) * cell;
    const bool corner = std::max(middle.x, middle.y) < cell, meeting = std::abs(middle.x - 0.4) < cell,
               stripe = std::abs(middle.x - 0.715) < cell;
    EXPECT_TRUE(corner || meeting || stripe) << middle.x << ", " << middle.y;
    ++fine;
  }
  EXPECT_GT(fine, 3u * 32u);
  EXPECT_LT(octree.node_count(), 3 * even.node_count());
}

/// Without finer cells the levels for them are removed; when the memory is insufficient cells stay as they are.
TEST(OctreeBuild, DetailCostsNothingWhereThereIsNoneOrNoRoom) {
  const auto same = [](const Octree& a, const Octree& b) { return a.words == b.words && a.colors == b.colors; };
  Primitive plate;
  plate.positions = {{0, 0, 0}, {1, 0.1f, 0}, {1, 0.1f, 1}, {0, 0, 1}};
  plate.indices = {0, 1, 2, 0, 2, 3};
  const Model flat(scene_of(plate));
  OctreeOptions options;
  options.depth = 5;
  const Octree even = build_octree(flat.source(), options);
  options.detail = 2;
  EXPECT_TRUE(same(build_octree(flat.source(), options), even));
  const Model model(plates());
  options.detail = 0;
  const Octree plain = build_octree(model.source(), options);
  options.detail = 2;
  EXPECT_FALSE(same(build_octree(model.source(), options), plain));
  options.max_nodes = plain.node_count();
  EXPECT_TRUE(same(build_octree(model.source(), options), plain));
}

TEST(OctreeBuild, RefusesADepthThatDoesNotFitAndNamesOneThatDoes) {
  const Model model(build_builtin_scene("sphere"));
  OctreeOptions options;
  options.depth = 7;
  const Octree six = [&] {
    OctreeOptions o;
    o.depth = 6;
    return build_octree(model.source(), o);
  }();
  options.max_nodes = six.node_count();
  try {
    build_octree(model.source(), options);
    ADD_FAILURE() << "took " << six.node_count();
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("octree.depth=6"), std::string::npos) << e.what();
  }
}

TEST(OctreeBuild, RebuildsOnlyWhatChanged) {
  Model model(build_builtin_scene("seat"));
  OctreeOptions options;
  options.depth = 6;
  const auto first = build_octree_bricks(model.source(), options, nullptr, {});
  const auto same = build_octree_bricks(model.source(), options, &*first, {});
  EXPECT_EQ(same->reused, same->bricks.size());
  // A dent near the middle: away from the bounds.
  std::size_t moved = 0;
  const Bounds bounds = compute_bounds(model.scene);
  const auto& points = model.geometry.positions;
  const glm::vec3 middle = *std::min_element(points.begin(), points.end(), [&](const glm::vec3& a, const glm::vec3& b) {
    return glm::length(a - bounds.center()) < glm::length(b - bounds.center());
  });
  for (glm::vec3& p : model.geometry.positions) {
    if (glm::length(p - middle) > 0.1f * bounds.radius()) continue;
    p.y += 0.01f;
    ++moved;
  }
  ASSERT_GT(moved, 3u);
  const auto second = build_octree_bricks(model.source(), options, &*first, {});
  EXPECT_GT(second->reused, 0u);
  EXPECT_LT(second->reused, second->bricks.size());
  const OctreeBricks grid_only{second->grid, {}, 0};
  const Octree patched = assemble_octree(*second);
  const Octree fresh = assemble_octree(*build_octree_bricks(model.source(), options, &grid_only, {}));
  EXPECT_EQ(patched.words, fresh.words);
  EXPECT_EQ(patched.colors, fresh.colors);
  EXPECT_EQ(patched.planes, fresh.planes);
}

TEST(OctreeBuild, NothingIsAnEmptyTree) {
  Primitive p;
  p.positions = {{0.0f, 0.0f, 0.0f}, {1.0f, 0.0f, 0.0f}, {std::nanf(""), 0.0f, 0.0f}};
  p.indices = {0, 1, 2, 0, 0, 1};
  const Model model(scene_of(p));
  const Octree octree = build_octree(model.source(), {});
  EXPECT_TRUE(octree.empty());
}

}  // namespace
}  // namespace maquette
