#include "render/prt/transfer.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <set>

#include "render/prt/buried_vertices.h"
#include "render/prt/factorised_transfer.h"
#include "render/prt/relight.h"
#include "render/prt/vertex_density.h"
#include "scenes/btf/half_floats.h"
#include "tests/support/small_btf.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

/// A plate with a block over a part of it: shadows of every direction.
FlatGeometry shadowed_plate() {
  Scene scene;
  scene.materials.push_back(test::matte(glm::vec3(0.5f)));
  test::add(&scene, test::make_grid({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 3, 0), "plate");
  test::add(&scene, test::make_grid({-0.5f, 0.5f, 0.2f}, {0.8f, 0, 0}, {0, 0.5f, 0}, 1, 0), "block");
  return flatten(scene);
}

/// Whether a ray meets a triangle, in double. Source: Moller and Trumbore 1997.
bool meets(const FlatGeometry& g, const glm::dvec3& origin, const glm::dvec3& d) {
  for (std::size_t i = 0; i + 2 < g.indices.size(); i += 3) {
    const glm::dvec3 p0(g.positions[g.indices[i]]), e1 = glm::dvec3(g.positions[g.indices[i + 1]]) - p0,
                                                    e2 = glm::dvec3(g.positions[g.indices[i + 2]]) - p0;
    const glm::dvec3 p = glm::cross(d, e2), s = origin - p0, q = glm::cross(s, e1);
    const double det = glm::dot(e1, p), u = glm::dot(s, p) / det, v = glm::dot(d, q) / det;
    if (std::abs(det) > 1e-14 && u >= 0.0 && v >= 0.0 && u + v <= 1.0 && glm::dot(e2, q) / det > 1e-4) return true;
  }
  return false;
}

std::vector<bool> all_of(const FlatGeometry& g) { return std::vector<bool>(g.items.size(), true); }

TEST(TransferMesh, DividesTrianglesWithSharedVertices) {
  const FlatGeometry g = shadowed_plate();
  for (const std::size_t wanted : {std::size_t{0}, std::size_t{100}, std::size_t{2000}}) {
    const TransferMesh mesh = make_transfer_mesh(g, {{.item = 0}, {.item = 1}}, wanted);
    EXPECT_GE(mesh.vertices.size(), wanted);
    EXPECT_EQ(mesh.triangles.size(), 20u);
    std::set<std::array<float, 3>> places;
    for (const TransferVertex& v : mesh.vertices) {
      EXPECT_TRUE(places.insert({v.position.x, v.position.y, v.position.z}).second) << "a vertex stands twice";
      EXPECT_NEAR(glm::dot(v.n, v.t), 0.0f, 1e-6f);
      EXPECT_NEAR(glm::length(v.b), 1.0f, 1e-6f);
    }
    // What is found at a point of a triangle interpolates its position exactly.
    for (const auto& triangle : mesh.triangles)
      for (const glm::vec2& b : {glm::vec2(0.0f), glm::vec2(1, 0), glm::vec2(0, 1), glm::vec2(0.2f, 0.3f),
                                 glm::vec2(0.61f, 0.17f), glm::vec2(0.5f, 0.5f)}) {
        const TransferCorners c = find_transfer_corners(mesh, triangle, b);
        glm::vec3 sum(0.0f), expected(0.0f);
        for (int k = 0; k < 3; ++k) {
          EXPECT_GE(c.share[k], -1e-5f);
          sum += c.share[k] * mesh.vertices[c.vertex[k]].position;
          const float w = k == 0 ? 1.0f - b.x - b.y : b[k - 1];
          expected += w * g.positions[g.indices[3 * triangle.source + static_cast<std::uint32_t>(k)]];
        }
        EXPECT_NEAR(glm::length(sum - expected), 0.0f, 1e-5f) << b.x << " " << b.y << " level " << triangle.level;
      }
  }
}

TEST(TransferMesh, LeavesOutWhatHasNoArea) {
  FlatGeometry g = shadowed_plate();
  const std::uint32_t last = static_cast<std::uint32_t>(g.positions.size());
  g.positions.push_back({5, 5, 5});  // isolated
  g.normals.push_back({0, 1, 0});
  g.tangents.push_back({1, 0, 0, 1});
  g.indices[0] = g.indices[1];                  // degenerate
  g.positions[g.indices[5]].x = std::nanf("");  // not finite
  const TransferMesh mesh = make_transfer_mesh(g, {{.item = 0}}, 0);
  EXPECT_LT(mesh.triangles.size(), 18u);
  for (const TransferVertex& v : mesh.vertices) {
    EXPECT_TRUE(std::isfinite(v.position.x));
    EXPECT_NE(v.position, g.positions[last]);
  }
}

TEST(ArrivingLight, IsVisibilityTimesCosine) {
  const FlatGeometry g = shadowed_plate();
  const TransferMesh mesh = make_transfer_mesh(g, {{.item = 0}}, 0);
  const CubeDirections cube(8);
  const std::atomic<bool> never{false};
  const ArrivingLight light = trace_arriving_light(mesh, cube, build_ray_scene(g, all_of(g)), {.rays = 1}, never);
  ASSERT_EQ(light.first.size(), mesh.vertices.size() + 1);
  std::size_t shadowed = 0, different = 0;
  for (std::size_t t = 0; t < mesh.vertices.size(); ++t) {
    const TransferVertex& v = mesh.vertices[t];
    std::vector<double> found(static_cast<std::size_t>(cube.count()), 0.0);
    for (std::size_t e = light.first[t]; e < light.first[t + 1]; ++e) {
      found[light.entries[e].direction] = static_cast<double>(light.entries[e].arriving);
      EXPECT_GT(light.entries[e].local.z, 0.0f);
    }
    for (Eigen::Index d = 0; d < cube.count(); ++d) {
      const double cosine = glm::dot(glm::dvec3(v.n), cube.direction(d));
      const glm::dvec3 inset(v.inside - v.n * std::min(glm::dot(v.inside, v.n), 0.0f));
      const bool blocked =
          cosine > 0.0 && meets(g, glm::dvec3(v.position) + 0.02 * inset + 2e-5 * glm::dvec3(v.n), cube.direction(d));
      shadowed += blocked;
      if (std::abs(found[static_cast<std::size_t>(d)] - (blocked ? 0.0 : std::max(cosine, 0.0))) > 1e-5) ++different;
    }
  }
  EXPECT_GT(shadowed, 40u);
  EXPECT_EQ(different, 0u);
}

/// A strip along z, bent along x: a valley or a ridge with smooth normals.
FlatGeometry bent_strip(float curvature) {
  FlatGeometry g;
  constexpr int kColumns = 9, kRows = 3;
  for (int j = 0; j < kRows; ++j)
    for (int i = 0; i < kColumns; ++i) {
      const float x = 0.1f * static_cast<float>(i - kColumns / 2);
      g.positions.push_back({x, 0.5f * curvature * x * x, 0.1f * static_cast<float>(j)});
      g.normals.push_back(glm::normalize(glm::vec3(-curvature * x, 1.0f, 0.0f)));
      g.tangents.push_back({1, 0, 0, 1});
      g.uv0.push_back({x, 0.0f});
      const auto at = static_cast<std::uint32_t>(j * kColumns + i);
      if (i + 1 < kColumns && j + 1 < kRows)
        for (const std::uint32_t k : {at, at + kColumns, at + 1, at + 1, at + kColumns, at + kColumns + 1})
          g.indices.push_back(k);
    }
  DrawItem item;
  item.index_count = static_cast<std::uint32_t>(g.indices.size());
  item.vertex_count = static_cast<std::uint32_t>(g.positions.size());
  g.items.push_back(item);
  return g;
}

TEST(ArrivingLight, VerticesOfFoldsStandAboveTheirSurface) {
  for (const float curvature : {-3.0f, -0.5f, 0.5f, 3.0f}) {
    const FlatGeometry g = bent_strip(curvature);
    const TransferMesh mesh = make_transfer_mesh(g, {{.item = 0}}, 200);
    const CubeDirections cube(8);
    const std::atomic<bool> never{false};
    const ArrivingLight light = trace_arriving_light(mesh, cube, build_ray_scene(g, all_of(g)), {}, never);
    for (std::size_t t = 0; t < mesh.vertices.size(); ++t) {
      // Of a constant sky at least the zenith's half arrives: no slope here is steeper than 52 degrees.
      double sum = 0.0;
      for (std::size_t e = light.first[t]; e < light.first[t + 1]; ++e)
        sum += static_cast<double>(light.entries[e].arriving) * cube.solid_angles()[light.entries[e].direction];
      EXPECT_GT(sum, 0.5 * 3.14159265) << curvature << " at x = " << mesh.vertices[t].position.x;
    }
  }
}

TEST(VertexDensity, DividesPartsWhereTheirShadowsNeedIt) {
  Scene scene;
  scene.materials.push_back(test::matte(glm::vec3(0.5f)));
  test::add(&scene, test::make_grid({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 3, 0), "shadowed");
  test::add(&scene, test::make_grid({39, 0, 1}, {2, 0, 0}, {0, 0, -2}, 3, 0), "open");
  test::add(&scene, test::make_grid({-0.5f, 0.5f, 0.2f}, {0.8f, 0, 0}, {0, 0.5f, 0}, 1, 0), "block");
  const FlatGeometry g = flatten(scene);
  const RayScene rays = build_ray_scene(g, all_of(g));
  const std::atomic<bool> never{false};
  double last = 1.0;
  for (int level = 0; level < 4; ++level) {
    const double error = vertex_interpolation_error(g, {.item = 0, .level = level}, rays, never);
    EXPECT_GT(error, 0.0);
    EXPECT_LT(error, level == 0 ? 1.0 : 0.9 * last) << level;
    last = error;
  }
  EXPECT_LT(vertex_interpolation_error(g, {.item = 1}, rays, never), 0.01);
  std::vector<TransferPart> parts{{.item = 0}, {.item = 1}};
  const auto chosen = choose_vertex_density(g, rays, 0.15, 100000, never, &parts);
  EXPECT_GT(parts[0].level, 0);
  EXPECT_EQ(parts[1].level, 0);
  EXPECT_EQ(chosen[0].level, parts[0].level);
  EXPECT_LE(chosen[0].error, 0.15);
  // Not more than wanted, and then it says what is missed.
  std::vector<TransferPart> few{{.item = 0}, {.item = 1}};
  const auto limited = choose_vertex_density(g, rays, 0.001, 200, never, &few);
  EXPECT_LE(make_transfer_mesh(g, few, 0).vertices.size(), 200u);
  EXPECT_GT(limited[0].error, 0.001);
}

TEST(ArrivingLight, NothingReachesTheInsideOfAClosedBox) {
  const FlatGeometry g = flatten(test::box_scene(6, 2, test::matte(glm::vec3(0.5f))));
  std::vector<TransferPart> parts;
  for (std::size_t i = 0; i < g.items.size(); ++i) parts.push_back({.item = i});
  const TransferMesh mesh = make_transfer_mesh(g, parts, 0);
  const std::atomic<bool> never{false};
  const ArrivingLight light = trace_arriving_light(mesh, CubeDirections(8), build_ray_scene(g, all_of(g)), {}, never);
  EXPECT_TRUE(light.entries.empty());
}

/// A plate in y = 0 and a closed block over its middle that begins at height `bottom`.
FlatGeometry plate_under_block(float bottom) {
  Scene scene;
  scene.materials.push_back(test::matte(glm::vec3(0.5f)));
  test::add(&scene, test::make_grid({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 16, 0), "plate");
  const glm::vec3 low(-0.6f, bottom, -0.6f), x(1.2f, 0, 0), y(0, 1, 0), z(0, 0, 1.2f);
  const auto side = [&](const glm::vec3& corner, const glm::vec3& u, const glm::vec3& v) {
    test::add(&scene, test::make_grid(corner, u, v, 1, 0), "block");
  };
  side(low, x, z), side(low + y, z, x), side(low, y, x), side(low + z, x, y), side(low, z, y), side(low + x, y, z);
  return flatten(scene);
}

TEST(BuriedVertices, TakeTheLightOfTheirNearestLitNeighbours) {
  const CubeDirections cube(8);
  const std::atomic<bool> never{false};
  for (const float bottom : {-0.5f, 1e-3f}) {
    const FlatGeometry g = plate_under_block(bottom);
    const TransferMesh mesh = make_transfer_mesh(g, {{.item = 0}}, 0);
    const RayScene scene = build_ray_scene(g, all_of(g));
    const ArrivingLight before = trace_arriving_light(mesh, cube, scene, {}, never);
    const std::vector<bool> buried = find_buried_vertices(mesh, g, cube, scene, before);
    ArrivingLight after = before;
    take_light_of(light_sources(mesh, buried, before), &after);
    std::size_t count = 0;
    for (std::size_t v = 0; v < mesh.vertices.size(); ++v) {
      const glm::vec3 p = mesh.vertices[v].position;
      const bool under = std::abs(p.x) < 0.6f && std::abs(p.z) < 0.6f;
      // Under the block's bottom it is dark, and not buried: the bottom turns its front to it.
      EXPECT_EQ(buried[v], under && bottom < 0.0f) << p.x << " " << p.z;
      count += buried[v];
      EXPECT_EQ(after.first[v + 1] > after.first[v], !under || bottom < 0.0f);
      if (!buried[v]) {
        ASSERT_EQ(after.first[v + 1] - after.first[v], before.first[v + 1] - before.first[v]);
        continue;
      }
      double sum = 0.0;
      for (std::size_t e = after.first[v]; e < after.first[v + 1]; ++e)
        sum += static_cast<double>(after.entries[e].arriving) * cube.solid_angles()[after.entries[e].direction];
      EXPECT_NEAR(sum, 0.6 * std::numbers::pi, 0.2 * std::numbers::pi);  // beside a wall
    }
    EXPECT_EQ(count, bottom < 0.0f ? 81u : 0u);
  }
}

struct SmallCase {
  FlatGeometry geometry = shadowed_plate();
  TransferMesh mesh = make_transfer_mesh(geometry, {{.item = 0}}, 60);
  CubeDirections cube{8};
  ArrivingLight arriving;
  SmallCase() {
    const std::atomic<bool> never{false};
    arriving = trace_arriving_light(mesh, cube, build_ray_scene(geometry, all_of(geometry)), {}, never);
  }
};

CubeLight test_light(const CubeDirections& cube) {
  CubeLight light(cube.count(), 3);
  for (Eigen::Index i = 0; i < cube.count(); ++i) {
    const glm::dvec3& d = cube.direction(i);
    const double sun = glm::dot(d, glm::normalize(glm::dvec3(0.4, 0.7, 0.3))) > 0.97 ? 80.0 : 0.0;
    light.row(i) << static_cast<float>(1.0 + d.y + sun), static_cast<float>(0.8 + 0.5 * d.x + 0.9 * sun),
        static_cast<float>(1.2 + 0.8 * sun);
  }
  return light;
}

/// Radiance at a vertex with a texel of the BTF, towards one of its views: plain sums over all directions.
glm::dvec3 slow_radiance(const SmallCase& s, const Btf& btf, std::size_t vertex, std::size_t view, int texel,
                         const CubeLight& light) {
  glm::dvec3 sum(0.0);
  const BtfView& v = btf.views[view];
  std::vector<glm::vec3> factors(static_cast<std::size_t>(1 + btf.components));
  read_btf_factors(btf, v,
                   {{(static_cast<float>(texel % btf.width) + 0.5f) / static_cast<float>(btf.width),
                     (static_cast<float>(texel / btf.width) + 0.5f) / static_cast<float>(btf.height)},
                    0.0f},
                   factors.data());
  for (std::size_t e = s.arriving.first[vertex]; e < s.arriving.first[vertex + 1]; ++e) {
    const auto& entry = s.arriving.entries[e];
    const DirectionWeights lights = v.lights->find(entry.local);
    glm::dvec3 rho(factors[0]);
    for (int c = 0; c < btf.components; ++c) {
      double h = 0.0;
      for (std::size_t k = 0; k < 3; ++k)
        h += static_cast<double>(lights.weight[static_cast<int>(k)]) *
             static_cast<double>(v.light_weights[static_cast<std::size_t>(lights.index[k] * btf.components + c)]);
      rho += h * glm::dvec3(factors[static_cast<std::size_t>(c + 1)]);
    }
    const double arriving = static_cast<double>(entry.arriving) * s.cube.solid_angles()[entry.direction];
    sum += rho * arriving * glm::dvec3(light(entry.direction, 0), light(entry.direction, 1), light(entry.direction, 2));
  }
  return sum;
}

TEST(FactorisedTransfer, AtFullRankEqualsPlainSums) {
  const SmallCase s;
  const auto btf = test::small_btf(2, 1);
  std::vector<std::uint32_t> all;
  for (std::uint32_t v = 0; v < s.mesh.vertices.size(); ++v) all.push_back(v);
  ASSERT_GT(all.size(), 60u);
  CubeLight haar = test_light(s.cube);
  for (int c = 0; c < 3; ++c) haar_transform_faces(s.cube.side(), haar.col(c).data());
  double squares = 0.0, light_sum = 0.0;
  int count = 0;
  const LightTable table(s.arriving, all, btf->views[0].lights);
  const TransferPcaOptions full{.clusters = 2, .components = static_cast<int>(all.size())};
  for (const std::size_t view : {std::size_t{0}, std::size_t{3}, std::size_t{12}}) {
    const std::array<TransferMatrix, 2> matrices = {
        factorise_transfer(table.transfer(s.cube.count(), {}, 0, 0), s.cube, full),
        factorise_transfer(table.transfer(s.cube.count(), btf->views[view].light_weights, 1, 0), s.cube, full)};
    RelightTable relight(s.cube.side(), matrices[0].rows() + matrices[1].rows());
    const std::size_t rows[2] = {relight.add(matrices[0]), relight.add(matrices[1])};
    std::vector<glm::vec4> sums;
    relight.sums(choose_coefficients(haar, relight.importance(), relight.coefficients()), &sums);
    for (std::size_t v = 0; v < all.size(); v += 7)
      for (int texel = 0; texel < 4; ++texel) {
        std::vector<glm::vec3> factors(2);
        read_btf_factors(
            *btf, btf->views[view],
            {{(static_cast<float>(texel % 2) + 0.5f) / 2.0f, (static_cast<float>(texel / 2) + 0.5f) / 2.0f}, 0.0f},
            factors.data());
        glm::dvec3 found(0.0);
        for (std::size_t m = 0; m < 2; ++m) {
          const auto terms = static_cast<std::size_t>(1 + matrices[m].components);
          const std::size_t first = rows[m] + matrices[m].owner[v] * terms;
          glm::dvec3 transfer(sums[first]);
          for (std::size_t c = 1; c < terms; ++c)
            transfer += static_cast<double>(float_of_half(matrices[m].weights[v * (terms - 1) + c - 1])) *
                        glm::dvec3(sums[first + c]);
          found += transfer * glm::dvec3(factors[m]);
        }
        const glm::dvec3 expected = slow_radiance(s, *btf, v, view, texel, test_light(s.cube));
        squares += glm::dot(found - expected, found - expected);
        light_sum += expected.x + expected.y + expected.z;
        count += 3;
      }
  }
  EXPECT_LT(std::sqrt(squares / count) / (light_sum / count), 0.005);
}

TEST(FactorisedTransfer, ErrorIsThatOfTheDecodedTransfer) {
  const SmallCase s;
  std::vector<std::uint32_t> all;
  for (std::uint32_t v = 0; v < s.mesh.vertices.size(); ++v) all.push_back(v);
  const auto btf = test::small_btf(1, 2);
  const LightTable table(s.arriving, all, btf->views[5].lights);
  const Eigen::MatrixXf transfer = table.transfer(s.cube.count(), btf->views[5].light_weights, 2, 1);
  double last = 1.0;
  for (const int components : {0, 1, 4, 16}) {
    const TransferMatrix m = factorise_transfer(transfer, s.cube, {.clusters = 4, .components = components});
    const Eigen::MatrixXf difference =
        s.cube.solid_angles().cwiseSqrt().cast<float>().asDiagonal() * (decode_transfer(m, s.cube) - transfer);
    const Eigen::MatrixXf scaled = s.cube.solid_angles().cwiseSqrt().cast<float>().asDiagonal() * transfer;
    EXPECT_NEAR(static_cast<double>(difference.norm() / scaled.norm()), m.error, 0.002);
    EXPECT_LT(m.error, last);
    last = m.error;
  }
}

TEST(FactorisedTransfer, StandsBlackFewAndEqualVertices) {
  const CubeDirections cube(4);
  const TransferMatrix black =
      factorise_transfer(Eigen::MatrixXf::Zero(96, 50), cube, {.clusters = 8, .components = 3});
  EXPECT_EQ(black.error, 0.0);
  for (const std::uint16_t q : black.q) EXPECT_EQ(q & 0x7fff, 0);
  Eigen::MatrixXf few = Eigen::MatrixXf::Random(96, 3);
  const TransferMatrix more_clusters = factorise_transfer(few, cube, {.clusters = 32, .components = 6});
  EXPECT_LE(more_clusters.clusters, 3);
  EXPECT_LT((decode_transfer(more_clusters, cube) - few).norm() / few.norm(), 0.002);
  const Eigen::MatrixXf equal = few.col(0).replicate(1, 40);
  EXPECT_LT((decode_transfer(factorise_transfer(equal, cube, {.clusters = 4, .components = 2}), cube) - equal).norm() /
                equal.norm(),
            0.002);
  const Eigen::MatrixXf rank_one = few.col(0) * Eigen::RowVectorXf::LinSpaced(40, 0.1f, 2.0f);
  EXPECT_LT(
      (decode_transfer(factorise_transfer(rank_one, cube, {.clusters = 2, .components = 6}), cube) - rank_one).norm() /
          rank_one.norm(),
      0.002);
}

}  // namespace
}  // namespace maquette
