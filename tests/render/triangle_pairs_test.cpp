// Tests of the properties of triangle pairs, and of rays through the quads that they make, against every triangle
// separately, in double.
#include "render/reference/triangle_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>
#include <random>

#include "render/reference/path_scene.h"
#include "render/reference/traversal.h"
#include "tests/support/path_scenes.h"

namespace maquette {
namespace {

using Corners = std::array<std::uint32_t, 3>;

struct Model {
  std::vector<glm::vec3> positions;
  std::vector<std::uint32_t> indices;
  void add(std::uint32_t a, std::uint32_t b, std::uint32_t c) { indices.insert(indices.end(), {a, b, c}); }
  Corners corners(std::uint32_t triangle) const {
    return {indices[3 * triangle], indices[3 * triangle + 1], indices[3 * triangle + 2]};
  }
  std::uint32_t count() const { return static_cast<std::uint32_t>(indices.size() / 3); }
};

/// A height field of side^2 cells, two triangles each, in random order with randomly rotated corners.
Model terrain(std::uint32_t side, float height, std::mt19937* random) {
  Model model;
  std::uniform_real_distribution<float> lift(-height, height);
  for (std::uint32_t y = 0; y <= side; ++y)
    for (std::uint32_t x = 0; x <= side; ++x)
      model.positions.emplace_back(static_cast<float>(x), lift(*random), static_cast<float>(y));
  std::vector<Corners> triangles;
  for (std::uint32_t y = 0; y < side; ++y)
    for (std::uint32_t x = 0; x < side; ++x) {
      const std::uint32_t a = y * (side + 1) + x, b = a + side + 1;
      triangles.push_back({a, b, a + 1});
      triangles.push_back({a + 1, b, b + 1});
    }
  std::shuffle(triangles.begin(), triangles.end(), *random);
  for (Corners& t : triangles) {
    std::rotate(t.begin(), t.begin() + (*random)() % 3, t.end());
    model.add(t[0], t[1], t[2]);
  }
  return model;
}

bool is_rotation(const Corners& a, const Corners& b) {
  return a == b || a == Corners{b[1], b[2], b[0]} || a == Corners{b[2], b[0], b[1]};
}

/// Pairs all triangles of a model and checks everything that holds for any model.
TrianglePairs pair_all(Model* model) {
  const Model before = *model;
  std::vector<std::uint32_t> all(model->count());
  std::iota(all.begin(), all.end(), 0u);
  TrianglePairs pairs = pair_triangles(all, model->positions, model->indices);
  std::vector<std::uint32_t> sorted = pairs.order;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(sorted, all);
  for (std::uint32_t t = 0; t < model->count(); ++t) EXPECT_TRUE(is_rotation(model->corners(t), before.corners(t)));
  for (std::uint32_t i = 0; i < pairs.pair_count; ++i) {
    const Corners first = model->corners(pairs.order[2 * i]), second = model->corners(pairs.order[2 * i + 1]);
    EXPECT_EQ(first[1], second[2]);
    EXPECT_EQ(first[2], second[1]);
  }
  return pairs;
}

TEST(TrianglePairs, HalvesOfRectanglesFindEachOther) {
  std::mt19937 random(1);
  Model model = terrain(40, 0.0f, &random);
  const TrianglePairs pairs = pair_all(&model);
  EXPECT_EQ(pairs.pair_count, 1600u);
  // Across the diagonal, which makes the smallest boxes, not along a strip.
  for (std::uint32_t i = 0; i < pairs.pair_count; ++i) {
    const Corners t = model.corners(pairs.order[2 * i]);
    EXPECT_FLOAT_EQ(glm::distance(model.positions[t[1]], model.positions[t[2]]), std::sqrt(2.0f));
  }
}

TEST(TrianglePairs, NearlyAllOfARoughSurfaceArePaired) {
  std::mt19937 random(2);
  Model model = terrain(60, 0.3f, &random);
  EXPECT_GT(pair_all(&model).pair_count, 3400u);  // of 3,600
}

TEST(TrianglePairs, PairOnlyTheGivenTriangles) {
  std::mt19937 random(3);
  Model model = terrain(8, 0.1f, &random);
  const std::vector<std::uint32_t> before = model.indices;
  std::vector<std::uint32_t> some;
  for (std::uint32_t t = 0; t < model.count(); t += 3) some.push_back(t);
  const TrianglePairs pairs = pair_triangles(some, model.positions, model.indices);
  EXPECT_EQ(pairs.order.size(), some.size());
  for (std::uint32_t t = 0; t < model.count(); ++t)
    if (t % 3 != 0) {
      EXPECT_TRUE(std::equal(&before[3 * t], &before[3 * t] + 3, &model.indices[3 * t]));
    }
}

TEST(TrianglePairs, EdgesOfManyTrianglesAndVerticesOfMoreAreFine) {
  constexpr std::uint32_t kLeaves = 20000;
  Model book;  // all leaves share the spine, half of them run along it, half against it
  book.positions = {{0.0f, 0.0f, 0.0f}, {0.0f, 1.0f, 0.0f}};
  Model fan;  // around its first vertex
  fan.positions = {{0.0f, 0.0f, 0.0f}};
  for (std::uint32_t i = 0; i < kLeaves; ++i) {
    const float angle = 6.2831853f * static_cast<float>(i) / kLeaves;
    book.positions.emplace_back(std::cos(angle), 0.5f, std::sin(angle));
    fan.positions.emplace_back(std::cos(angle), 0.0f, std::sin(angle));
    if (i % 2 == 0)
      book.add(0, 1, 2 + i);
    else
      book.add(1, 0, 2 + i);
    fan.add(0, 1 + i, 1 + (i + 1) % kLeaves);
  }
  pair_all(&book);
  EXPECT_GT(pair_all(&fan).pair_count, kLeaves * 4 / 9);
}

TEST(TrianglePairs, WindingsThatDisagreeAndTrianglesWithoutAreaStayAlone) {
  Model model;
  model.positions = {{0, 0, 0}, {1, 0, 0}, {0, 0, 1}, {1, 0, 1}};
  model.add(0, 1, 2);
  model.add(1, 2, 3);  // the same way along 1-2
  EXPECT_EQ(pair_all(&model).pair_count, 0u);
  Model without_area = model;
  without_area.indices = {0, 0, 1, 2, 3, 2, 1, 1, 1};
  EXPECT_EQ(pair_all(&without_area).pair_count, 0u);
}

TEST(TrianglePairs, CreasesAreNoPairs) {
  Model model;  // a narrow flap upright on a large floor: the box around both is mostly empty
  model.positions = {{0, 0, 0}, {1, 0, 0}, {0, 0, -1}, {0.5f, 3.0f, 0.0f}};
  model.add(0, 1, 2);
  model.add(1, 0, 3);
  EXPECT_EQ(pair_all(&model).pair_count, 0u);
}

/// Nearest hit of all triangles, in double (Moeller and Trumbore 1997). Unsure where a ray passes so close to an edge
/// that rounding decides.
struct ExactHit {
  double distance = 1e30;
  std::uint32_t triangle = kNoTriangle;
  bool sure = true;
};
ExactHit nearest(const PathScene& scene, const Ray& ray, bool backs) {
  ExactHit best;
  for (std::uint32_t t = 0; t < scene.mesh_begin[PathScene::kHidden]; ++t) {
    const auto& p = scene.triangles[t].positions;
    const glm::dvec3 p0(p[0]), e1 = glm::dvec3(p[1]) - p0, e2 = glm::dvec3(p[2]) - p0, d(ray.direction);
    const glm::dvec3 from = glm::dvec3(ray.origin) - p0, across = glm::cross(d, e2), along = glm::cross(from, e1);
    const double facing = glm::dot(e1, across);  // against the normal
    if (facing == 0.0 || (!backs && facing < 0.0)) continue;
    const double u = glm::dot(from, across) / facing, v = glm::dot(d, along) / facing,
                 at = glm::dot(e2, along) / facing;
    const double inside = std::min({u, v, 1.0 - u - v});
    if (at <= 0.0) continue;
    if (std::abs(inside) < 1e-4 && at < best.distance + 1e-3) best.sure = false;
    if (inside >= 0.0 && at < best.distance) best = {at, t, best.sure};
  }
  return best;
}

/// Mostly quads, or a soup of triangles that share no vertex.
Scene rough_scene(bool soup, std::mt19937* random) {
  const Model model = terrain(12, 0.6f, random);
  Primitive p;
  for (std::uint32_t i = 0; i < model.indices.size(); ++i) {
    const glm::vec3& position = model.positions[model.indices[i]];
    if (soup) {
      p.positions.push_back(position);
      p.indices.push_back(i);
    }
  }
  if (!soup) {
    p.positions = model.positions;
    p.indices.assign(model.indices.begin(), model.indices.end() - 9);  // three have lost their partner
  }
  p.normals.assign(p.positions.size(), {0.0f, 1.0f, 0.0f});
  Material material;
  material.double_sided = false;
  return test::scene_of(std::move(p), material);
}

void expect_nearest_hits(bool soup) {
  std::mt19937 random(soup ? 11 : 12);
  const auto scene = build_path_scene({.scene = rough_scene(soup, &random), .environment = test::constant_sky(1.0f)});
  EXPECT_EQ(scene->quads, !soup);
  std::uniform_real_distribution<float> coordinate(0.0f, 12.0f), side(-1.0f, 1.0f);
  int hits = 0, second_halves = 0;
  for (int i = 0; i < 20000; ++i) {
    const glm::vec3 direction(side(random), side(random), side(random));
    const Ray ray{{coordinate(random), side(random) * 2.0f, coordinate(random)}, glm::normalize(direction)};
    const RayKind kind = i % 2 == 0 ? RayKind::camera : RayKind::path;
    const ExactHit exact = nearest(*scene, ray, kind == RayKind::path);
    if (!exact.sure) continue;
    RayHit hit;
    ASSERT_EQ(intersect(*scene, ray, kind, 0, &hit), exact.triangle != kNoTriangle) << i;
    if (kind == RayKind::path) {
      EXPECT_EQ(is_unoccluded(*scene, ray), exact.triangle == kNoTriangle) << i;
    }
    if (exact.triangle == kNoTriangle) continue;
    ++hits;
    ASSERT_EQ(hit.triangle, exact.triangle) << i;
    EXPECT_NEAR(hit.distance, exact.distance, 1e-4 * (1.0 + exact.distance)) << i;
    const auto& p = scene->triangles[hit.triangle].positions;
    const glm::vec3 at =
        p[0] * (1.0f - hit.barycentric.x - hit.barycentric.y) + p[1] * hit.barycentric.x + p[2] * hit.barycentric.y;
    EXPECT_LT(glm::distance(at, ray.origin + ray.direction * hit.distance), 1e-4f) << i;
    second_halves += hit.triangle < 2 * scene->pair_count[PathScene::kOpaque] && hit.triangle % 2 == 1 ? 1 : 0;
  }
  EXPECT_GT(hits, 4000);
  if (!soup) {
    EXPECT_GT(second_halves, 1500);
  }
}

TEST(TrianglePairs, RaysHitTheSameTrianglesAsOneByOne) { expect_nearest_hits(false); }
TEST(TrianglePairs, SoupsAreTracedAsTriangles) { expect_nearest_hits(true); }

TEST(TrianglePairs, NoRaySlipsThroughTheDiagonalsOrEdges) {
  std::mt19937 random(21);
  const auto scene = build_path_scene({.scene = rough_scene(false, &random), .environment = test::constant_sky(1.0f)});
  ASSERT_TRUE(scene->quads);
  // From above through points of edges, where the rounding of either triangle may miss; not through the hole.
  std::uniform_real_distribution<float> unit(0.0f, 1.0f);
  int through = 0;
  for (int i = 0; i < 200000; ++i) {
    const TracedTriangle& t = scene->triangles[random() % scene->mesh_begin[PathScene::kHidden]];
    const std::size_t k = random() % 3;
    const glm::vec3 at = glm::mix(t.positions[k], t.positions[(k + 1) % 3], unit(random));
    if (at.x < 0.01f || at.x > 11.99f || at.z < 0.01f || at.z > 11.99f) continue;
    const glm::vec3 eye = at + glm::vec3(unit(random) - 0.5f, 5.0f, unit(random) - 0.5f);
    RayHit hit;
    through += intersect(*scene, {eye, at - eye}, RayKind::path, 0, &hit) ? 0 : 1;
  }
  // The three triangles that were left out border on nine edges at most: 1.1 % of the edges, where half may pass.
  EXPECT_LT(through, 2000);
  EXPECT_GT(through, 0);
}

}  // namespace
}  // namespace maquette
