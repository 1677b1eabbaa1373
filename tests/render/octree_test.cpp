#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "render/octree/octree_build.h"
#include "render/octree/octree_clip.h"
#include "render/octree/octree_shared.h"
#include "scenes/error.h"

namespace maquette {
namespace {

/// The same source in double.
namespace exact {
using namespace glm;
using shared::octree_plane_word;
using shared::octree_word;
inline double max(double a, double b) { return std::max(a, b); }
inline double min(double a, double b) { return std::min(a, b); }
inline double clamp(double v, double low, double high) { return std::clamp(v, low, high); }
inline int clamp(int v, int low, int high) { return std::clamp(v, low, high); }
#define float double
#define vec3 dvec3
#include "shared/octree.glsl"
#undef float
#undef vec3
}  // namespace exact

/// Owns the inputs of an OctreeSource.
struct Model {
  Scene scene;
  FlatGeometry geometry;
  std::vector<int> materials;
  std::vector<bool> transmits;
  std::unique_ptr<OctreePaint> textures;

  explicit Model(Scene s) : scene(std::move(s)) {
    geometry = flatten(scene);
    for (const DrawItem& item : geometry.items) {
      materials.push_back(item.patch >= 0 ? scene.patches[static_cast<std::size_t>(item.patch)].material
                                          : scene.meshes[static_cast<std::size_t>(item.mesh)]
                                                .primitives[static_cast<std::size_t>(item.primitive)]
                                                .material);
      const int m = materials.back();
      transmits.push_back(m >= 0 && scene.materials[static_cast<std::size_t>(m)].glass);
    }
    textures = std::make_unique<OctreePaint>(scene, scene.materials);
  }
  OctreeSource source() const { return {geometry, materials, transmits, *textures}; }
  double area() const {
    double sum = 0.0;
    for (std::size_t i = 0; i < geometry.items.size(); ++i) {
      if (transmits[i]) continue;
      const DrawItem& item = geometry.items[i];
      for (std::size_t k = item.first_index; k < item.first_index + item.index_count; k += 3) {
        const glm::dvec3 a = geometry.positions[geometry.indices[k]], b = geometry.positions[geometry.indices[k + 1]],
                         c = geometry.positions[geometry.indices[k + 2]];
        sum += 0.5 * glm::length(glm::cross(b - a, c - a));
      }
    }
    return sum;
  }
};

Scene scene_of(const Primitive& primitive) {
  Scene scene;
  scene.meshes.push_back({"mesh", {primitive}, nullptr});
  Node node;
  node.mesh = 0;
  scene.nodes.push_back(node);
  scene.roots = {0};
  return scene;
}

/// Random triangles of all sizes, and axis-parallel ones in the planes of the grid.
Scene soup(int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> u(-1.0f, 1.0f);
  Primitive p;
  p.material = 0;
  for (int i = 0; i < count; ++i) {
    const glm::vec3 center(u(random), u(random), u(random));
    const float size = std::exp2(-4.0f + 3.5f * u(random));
    for (int k = 0; k < 3; ++k) {
      glm::vec3 q = center + size * glm::vec3(u(random), u(random), u(random));
      if (i % 8 == 0) q[i / 8 % 3] = std::round(center[i / 8 % 3] * 8.0f) / 8.0f;
      p.indices.push_back(static_cast<std::uint32_t>(p.positions.size()));
      p.positions.push_back(glm::clamp(q, -1.0f, 1.0f));
    }
  }
  Scene scene = scene_of(p);
  scene.materials.emplace_back();
  return scene;
}

double total_area(const OctreeBricks& bricks) {
  double sum = 0.0;
  for (const auto& [code, entry] : bricks.bricks) sum += entry.brick.sums.area;
  const double cells_per_m = std::exp2(bricks.grid.depth) / bricks.grid.side_m;
  return sum / (cells_per_m * cells_per_m);
}

struct Box {
  glm::dvec3 low, high;
  std::uint32_t node;
  int level;
};

std::vector<Box> leaf_boxes(const Octree& octree) {
  std::vector<Box> boxes;
  for (const OctreeCell& leaf : list_leaves(octree)) {
    const double cell = std::exp2(octree.depth - leaf.level);
    const glm::dvec3 low = glm::dvec3(leaf.coordinate) * cell;
    boxes.push_back({low, low + cell, leaf.node, leaf.level});
  }
  return boxes;
}

struct Answer {
  double t = std::numeric_limits<double>::infinity();
  int node = -1;
};

/// Reference: every leaf is intersected with the ray, in double, directly by definition: the first chord of positive
/// length that meets the surface of its cell. `slack` widens (or narrows) chords and slabs by that fraction of a cell.
Answer brute_force(const Octree& octree, const std::vector<Box>& boxes, const shared::OctreeRay& ray, double slack) {
  Answer best;
  const double cells_per_m = std::exp2(octree.depth) / static_cast<double>(octree.side_m);
  const glm::dvec3 o = (glm::dvec3(ray.origin) - glm::dvec3(octree.corner)) * cells_per_m;
  const glm::dvec3 d = glm::dvec3(ray.direction) * cells_per_m;
  for (const Box& box : boxes) {
    double in = static_cast<double>(ray.t_min), out = static_cast<double>(ray.t_max);
    const double length = glm::length(d);
    for (int axis = 0; axis < 3; ++axis) {
      const double low = box.low[axis] - slack, high = box.high[axis] + slack;
      if (d[axis] == 0.0) {
        if (o[axis] < low || o[axis] >= high) out = -1.0;
        continue;
      }
      const double a = (low - o[axis]) / d[axis], b = (high - o[axis]) / d[axis];
      in = std::max(in, std::min(a, b));
      out = std::min(out, std::max(a, b));
    }
    if (!(in < out) || (slack < 0.0 && (out - in) * length < -slack)) continue;
    const bool last = box.level == octree.depth;
    const auto plane = exact::octree_unpack_plane(last ? octree.words[box.node] : octree.planes[box.node]);
    {
      const glm::dvec3 center = 0.5 * (box.low + box.high);
      const double cell = box.high.x - box.low.x;
      const double f0 = glm::dot(plane.normal, o - center) / cell - plane.offset;
      const double f1 = glm::dot(plane.normal, d) / cell;
      const double a = f0 + in * f1, b = f0 + out * f1;
      const double low = (plane.planar ? -exact::kOctreeSlab : plane.low) - slack;
      const double high = (plane.planar ? exact::kOctreeSlab : plane.high) + slack;
      if (std::min(a, b) > high || std::max(a, b) < low) continue;
      if (!plane.planar) {
        if (a < low || a > high) in += ((a < low ? low : high) - a) / f1;
        const double thickness = (plane.high - plane.low) * cell / (1 << octree.detail);
        const bool thin = thickness < exact::kOctreeThin && f1 < 0.0;
        if (in < static_cast<double>(ray.t_box) && !thin) continue;
      }
    }
    // Cells are met in the order of their entries.
    if (in < best.t) best = {in, static_cast<int>(box.node)};
  }
  return best;
}

exact::OctreeFrame exact_frame_of(const Octree& octree) {
  return {octree.corner, std::exp2(octree.depth) / static_cast<double>(octree.side_m), octree.depth, octree.detail};
}
exact::OctreeRay exact_ray(const shared::OctreeRay& r) {
  return {r.origin, r.direction, r.t_min, r.t_max, r.t_box, r.width, r.spread};
}

/// Random rays, and difficult ones: axis-parallel, diagonal through corners, along edges, from grid points, starting
/// inside.
std::vector<shared::OctreeRay> hard_rays(const Octree& octree, int count, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> u(-1.0f, 1.0f);
  const float side = octree.side_m;
  const int grid = 1 << octree.depth;
  std::vector<shared::OctreeRay> rays;
  for (int i = 0; i < count; ++i) {
    shared::OctreeRay ray{};
    const glm::vec3 center = octree.corner + 0.5f * side;
    ray.origin = center + side * (i % 2 ? 0.5f : 1.5f) * glm::vec3(u(random), u(random), u(random));
    ray.direction = glm::vec3(u(random), u(random), u(random));
    const int kind = i % 10;
    const auto on_grid = [&] {
      glm::vec3 p;
      for (int a = 0; a < 3; ++a)
        p[a] = octree.corner[a] + side *
                                      static_cast<float>(static_cast<int>(random() % static_cast<unsigned>(grid + 1))) /
                                      static_cast<float>(grid);
      return p;
    };
    if (kind == 1) ray.direction = glm::vec3(0.0f), ray.direction[i / 10 % 3] = i % 4 < 2 ? 1.0f : -1.0f;
    if (kind == 2) ray.direction[i / 10 % 3] = 0.0f;
    if (kind == 3) ray.origin = on_grid();
    if (kind == 4) ray.origin = on_grid(), ray.direction = on_grid() - ray.origin;
    if (kind == 5) {
      ray.origin = on_grid();
      ray.direction = glm::sign(ray.direction);
    }
    if (kind == 6)
      ray.origin = on_grid(), ray.direction = glm::vec3(0.0f), ray.direction[i / 10 % 3] = i % 4 < 2 ? 1.0f : -1.0f;
    if (kind == 7) ray.direction[i / 10 % 3] *= 1e-7f;
    if (glm::dot(ray.direction, ray.direction) < 1e-12f) ray.direction = glm::vec3(1.0f, 0.0f, 0.0f);
    ray.direction = glm::normalize(ray.direction);
    ray.t_max = 1e9f;
    rays.push_back(ray);
  }
  return rays;
}

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

/// A floor at y = 0.3 over [0, 1]^2 of two materials, with a border from `x0` at z = 0 to `x1` at z = 1.
Octree two_materials(float x0, float x1, int depth) {
  Primitive left, right;
  left.positions = {{0, 0.3f, 0}, {x0, 0.3f, 0}, {x1, 0.3f, 1}, {0, 0.3f, 1}};
  right.positions = {{x0, 0.3f, 0}, {1, 0.3f, 0}, {1, 0.3f, 1}, {x1, 0.3f, 1}};
  left.indices = right.indices = {0, 1, 2, 0, 2, 3};
  left.material = 0;
  right.material = 1;
  Scene scene = scene_of(left);
  scene.meshes[0].primitives.push_back(right);
  scene.materials.resize(2);
  const Model model(std::move(scene));
  OctreeOptions options;
  options.depth = depth;
  return build_octree(model.source(), options);
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

/// Two plates that meet at a right angle, one of them half of another material and with a stripe of another colour.
Scene plates() {
  const auto quad = [](const glm::vec3& o, const glm::vec3& a, const glm::vec3& b, int material, float shade) {
    Primitive p;
    p.positions = {o, o + a, o + a + b, o + b};
    p.colors.assign(4, glm::vec4(glm::vec3(shade), 1.0f));
    p.indices = {0, 1, 2, 0, 2, 3};
    p.material = material;
    return p;
  };
  Scene scene = scene_of(quad({0, 0, 0}, {0.4f, 0, 0}, {0, 0, 1}, 0, 0.8f));
  auto& all = scene.meshes[0].primitives;
  all.push_back(quad({0.4f, 0, 0}, {0.31f, 0, 0}, {0, 0, 1}, 1, 0.8f));
  all.push_back(quad({0.71f, 0, 0}, {0.01f, 0, 0}, {0, 0, 1}, 1, 0.1f));
  all.push_back(quad({0.72f, 0, 0}, {0.28f, 0, 0}, {0, 0, 1}, 1, 0.8f));
  all.push_back(quad({0, 0, 0}, {0, 0, 1}, {0, 1, 0}, 0, 0.8f));
  scene.materials.resize(2);
  return scene;
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
  // A dent in the middle: away from the bounds.
  std::size_t moved = 0;
  const Bounds bounds = compute_bounds(model.scene);
  for (glm::vec3& p : model.geometry.positions) {
    if (glm::length(p - bounds.center()) > 0.3f * bounds.radius()) continue;
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

struct TraceCount {
  int float_wrong = 0, exact_wrong = 0, hits = 0, rays = 0;
};

TraceCount compare_with_brute_force(const Octree& octree, int rays, unsigned seed, float t_box) {
  const std::vector<Box> boxes = leaf_boxes(octree);
  shared::octree_view = {octree.words.data(), octree.planes.data()};
  const auto frame = shared::octree_frame(octree);
  const auto exact_frame = exact_frame_of(octree);
  const double cells_per_m = std::exp2(octree.depth) / static_cast<double>(octree.side_m);
  TraceCount count;
  for (shared::OctreeRay ray : hard_rays(octree, rays, seed)) {
    ray.t_box = t_box;
    const auto hit = shared::octree_trace(frame, ray);
    const auto exact_hit = exact::octree_trace(exact_frame, exact_ray(ray));
    const Answer narrow = brute_force(octree, boxes, ray, -1e-3), wide = brute_force(octree, boxes, ray, 1e-3);
    ++count.rays;
    count.hits += hit.node >= 0;
    // Cells that the ray clearly crosses must be hit, and cells that it does not touch must not.
    const auto wrong = [&](double t, int node) {
      const double tolerance = 4e-3 / cells_per_m * (1.0 + 1e-3 * glm::length(glm::dvec3(ray.origin)) * cells_per_m);
      if (node < 0) return narrow.node >= 0;
      if (node == narrow.node || node == wide.node) return false;
      return t > narrow.t + tolerance || t < wide.t - tolerance;
    };
    count.float_wrong += wrong(hit.t, hit.node);
    count.exact_wrong += wrong(exact_hit.t, exact_hit.node);
  }
  return count;
}

TEST(OctreeTrace, HitsTheLeafThatBruteForceHits) {
  for (int depth : {1, 2, 4, 6}) {
    const Model model(soup(60, 7));
    OctreeOptions options;
    options.depth = depth;
    const Octree octree = build_octree(model.source(), options);
    const TraceCount count = compare_with_brute_force(octree, 1500, static_cast<unsigned>(depth), 0.0f);
    EXPECT_EQ(count.float_wrong, 0) << depth;
    EXPECT_EQ(count.exact_wrong, 0) << depth;
    EXPECT_GT(count.hits, count.rays / 10);
    EXPECT_LT(count.hits, count.rays);
  }
}

TEST(OctreeTrace, MeetsCoarseRegionsToo) {
  const Model model(build_builtin_scene("seat"));
  OctreeOptions options;
  options.depth = 6;
  const Bounds bounds = compute_bounds(model.scene);
  options.interest = {{bounds.min, bounds.center()}};
  const Octree octree = build_octree(model.source(), options);
  const TraceCount count = compare_with_brute_force(octree, 1000, 3, 0.02f);
  EXPECT_EQ(count.float_wrong, 0);
  EXPECT_EQ(count.exact_wrong, 0);
  EXPECT_GT(count.hits, 100);
}

TEST(OctreeTrace, MeetsCellsOfDetail) {
  const Model model(build_builtin_scene("seat"));
  OctreeOptions options;
  options.depth = 5;
  options.detail = 2;
  const Octree octree = build_octree(model.source(), options);
  ASSERT_EQ(octree.detail, 2);
  const TraceCount count = compare_with_brute_force(octree, 1000, 5, 0.02f);
  EXPECT_EQ(count.float_wrong, 0);
  EXPECT_EQ(count.exact_wrong, 0);
  EXPECT_GT(count.hits, 100);
}

/// Traversal finds every existing leaf, and no others.
TEST(OctreeSurface, FindsNodesByTheirCoordinates) {
  const Model model(plates());
  OctreeOptions options;
  options.depth = 5;
  options.detail = 2;
  const Octree octree = build_octree(model.source(), options);
  shared::octree_view = {octree.words.data(), octree.planes.data(), octree.colors.data()};
  std::vector<int> expected(std::size_t{1} << 3 * octree.depth, -1);
  const int side = 1 << octree.depth;
  for (const OctreeCell& leaf : list_leaves(octree)) {
    const int size = 1 << (octree.depth - leaf.level);
    for (int k = 0; k < size * size * size; ++k) {
      const glm::ivec3 p = leaf.coordinate * size + glm::ivec3(k % size, k / size % size, k / size / size);
      expected[static_cast<std::size_t>(p.x + side * (p.y + side * p.z))] = static_cast<int>(leaf.node);
    }
  }
  std::size_t wrong = 0;
  for (int k = 0; k < side * side * side; ++k) {
    const glm::ivec3 p(k % side, k / side % side, k / side / side);
    wrong += shared::octree_node_at(shared::octree_root(octree.depth), p, octree.depth).node !=
             expected[static_cast<std::size_t>(k)];
  }
  EXPECT_EQ(wrong, 0u);
  EXPECT_EQ(shared::octree_node_at(shared::octree_root(octree.depth), {0, side, 0}, octree.depth).node, -1);
}

/// For a sphere, interpolated normals are several times closer to the true ones than the mean normals of the cells.
TEST(OctreeSurface, InterpolatesNormals) {
  const Model model(build_builtin_scene("sphere"));
  OctreeOptions options;
  options.depth = 5;
  const Octree octree = build_octree(model.source(), options);
  shared::octree_view = {octree.words.data(), octree.planes.data(), octree.colors.data()};
  std::mt19937 random(11);
  std::normal_distribution<float> u;
  double of_means = 0.0, between = 0.0, largest = 0.0;
  for (int i = 0; i < 5000; ++i) {
    shared::OctreeRay ray{};
    const glm::vec3 p = glm::normalize(glm::vec3(u(random), u(random), u(random)));
    ray.origin = 3.0f * p;
    ray.direction = -p;
    ray.t_max = 10.0f;
    const auto hit = shared::octree_trace(shared::octree_frame(octree), ray);
    ASSERT_GE(hit.node, 0);
    const glm::vec3 at = ray.origin + hit.t * ray.direction;
    const auto surface = shared::octree_surface(shared::octree_frame(octree), hit, at, ray.direction);
    const glm::vec3 mean = glm::normalize(shared::octree_unpack_plane(shared::octree_word(hit.node)).normal);
    EXPECT_NEAR(glm::length(surface.normal), 1.0f, 1e-5f);
    const double error = std::acos(std::min(1.0, static_cast<double>(glm::dot(surface.normal, glm::normalize(at)))));
    between += error;
    largest = std::max(largest, error);
    of_means += std::acos(std::min(1.0, static_cast<double>(glm::dot(mean, glm::normalize(at)))));
  }
  EXPECT_LT(between, 0.4 * of_means);
  EXPECT_LT(largest, 0.03);  // half a cell is 0.03 rad
}

/// Where two materials meet at a slant, the border is closer to the true one than the size of the cells.
TEST(OctreeSurface, BordersOfMaterialsRunThroughCells) {
  const Octree octree = two_materials(0.3f, 0.6f, 4);
  shared::octree_view = {octree.words.data(), octree.planes.data(), octree.colors.data()};
  const double cell = static_cast<double>(octree.side_m) / 16.0;
  std::mt19937 random(2);
  std::uniform_real_distribution<float> u(0.1f, 0.9f);
  double farthest[2] = {};  // largest distance of a wrong material from the border: of the cells, and of the lookup
  for (int i = 0; i < 5000; ++i) {
    shared::OctreeRay ray{};
    ray.origin = {u(random), 1.0f, u(random)};
    ray.direction = {0.0f, -1.0f, 0.0f};
    ray.t_max = 10.0f;
    const auto hit = shared::octree_trace(shared::octree_frame(octree), ray);
    ASSERT_GE(hit.node, 0);
    const auto surface =
        shared::octree_surface(shared::octree_frame(octree), hit, ray.origin + hit.t * ray.direction, ray.direction);
    const double beyond = static_cast<double>(ray.origin.x - 0.3f - 0.3f * ray.origin.z) / cell;
    const int expected = beyond > 0.0;
    const int of_cell = shared::octree_unpack_color(octree.colors[static_cast<std::size_t>(hit.node)]).material;
    if (of_cell != expected) farthest[0] = std::max(farthest[0], std::abs(beyond));
    if (surface.material != expected) farthest[1] = std::max(farthest[1], std::abs(beyond));
    EXPECT_GT(surface.normal.y, 0.999f);
  }
  EXPECT_GT(farthest[0], 0.45);
  EXPECT_LT(farthest[1], 0.35);
}

TEST(OctreeTrace, AClosedSurfaceHasNoGaps) {
  const Model model(build_builtin_scene("sphere"));
  OctreeOptions options;
  options.depth = 7;
  const Octree octree = build_octree(model.source(), options);
  shared::octree_view = {octree.words.data(), octree.planes.data()};
  std::mt19937 random(5);
  std::normal_distribution<float> u;
  const float cell = octree.side_m / 128.0f;
  double largest = 0.0;
  for (int i = 0; i < 20000; ++i) {
    shared::OctreeRay ray{};
    ray.direction = glm::normalize(glm::vec3(u(random), u(random), u(random)));
    ray.origin = 0.9f * glm::normalize(glm::vec3(u(random), u(random), u(random)));
    ray.t_max = 10.0f;
    const auto hit = shared::octree_trace(shared::octree_frame(octree), ray);
    ASSERT_GE(hit.node, 0) << i;
    largest = std::max(largest, std::abs(static_cast<double>(glm::length(ray.origin + hit.t * ray.direction)) - 1.0));
  }
  EXPECT_LT(largest, 1.5 * static_cast<double>(cell));
}

TEST(OctreeTrace, AWideConeStopsAtCoarseCells) {
  const Model model(build_builtin_scene("sphere"));
  OctreeOptions options;
  options.depth = 8;
  const Octree octree = build_octree(model.source(), options);
  shared::octree_view = {octree.words.data(), octree.planes.data()};
  shared::OctreeRay ray{};
  ray.origin = glm::vec3(0.1f, 0.2f, 5.0f);
  ray.direction = glm::vec3(0.0f, 0.0f, -1.0f);
  ray.t_max = 100.0f;
  int last = 9;
  for (float spread : {0.0f, 0.005f, 0.02f, 0.08f}) {
    ray.spread = spread;
    const auto hit = shared::octree_trace(shared::octree_frame(octree), ray);
    ASSERT_GE(hit.node, 0);
    EXPECT_NEAR(hit.t, 4.0f, 0.2f);
    const float cell = octree.side_m / static_cast<float>(1 << hit.level);
    EXPECT_LE(hit.level, last);
    if (spread > 0.0f) {
      EXPECT_LE(cell, 1.01f * spread * hit.t);
      EXPECT_GT(2.2f * cell, spread * (hit.t - 2.0f * cell));
    } else {
      EXPECT_EQ(hit.level, 8);
    }
    last = hit.level;
  }
}

}  // namespace
}  // namespace maquette
