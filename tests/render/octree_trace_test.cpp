#include <gtest/gtest.h>

#include "tests/render/octree_models.h"

namespace maquette {
namespace {

using namespace test;

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
      glm::vec3 p{};
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
