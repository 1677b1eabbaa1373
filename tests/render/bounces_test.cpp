#include "render/prt/bounces.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>
#include <numbers>

#include "render/prt/factorised_transfer.h"
#include "render/prt/relight.h"
#include "scenes/btf/half_floats.h"
#include "tests/support/never.h"
#include "tests/support/small_btf.h"
#include "tests/support/test_scenes.h"

namespace maquette {
namespace {

/// One texel that reflects the same to all sides.
std::shared_ptr<const Btf> lambert_btf(const glm::vec3& albedo) {
  std::vector<glm::dvec3> directions{glm::dvec3(0.0, 0.0, 1.0)};
  for (int i = 0; i < 18; ++i)
    directions.push_back(i < 6 ? direction_of_angles(30.0, 60.0 * i) : direction_of_angles(60.0, 30.0 * (i - 6)));
  auto btf = std::make_shared<Btf>();
  btf->width = btf->height = 1;
  btf->components = 1;
  btf->texel_m = 0.1;
  const BtfLights lights = make_btf_lights(directions);
  for (const glm::dvec3& view : directions) {
    std::vector<float> images;
    for (std::size_t l = 0; l < directions.size(); ++l)
      for (int c = 0; c < 3; ++c) images.push_back(albedo[c] * std::numbers::inv_pi_v<float>);
    btf->views.push_back(factorise_btf_view(view, lights, 1, &images));
  }
  complete_btf(btf.get());
  return btf;
}

/// A sphere of radius 1 without its cap above the polar angle `open`, seen from within.
Scene bowl(double open, int rings, int around) {
  Primitive p;
  for (int j = 0; j <= rings; ++j)
    for (int i = 0; i < around; ++i) {
      const double theta = open + (std::numbers::pi - open) * j / rings, phi = 2.0 * std::numbers::pi * i / around;
      const glm::vec3 at(std::sin(theta) * std::sin(phi), std::cos(theta), std::sin(theta) * std::cos(phi));
      p.positions.push_back(at);
      p.normals.push_back(-at);
    }
  for (int j = 0; j < rings; ++j)
    for (int i = 0; i < around; ++i) {
      const auto at = [&](int ring, int k) { return static_cast<std::uint32_t>(ring * around + (i + k) % around); };
      for (const std::uint32_t k : {at(j, 0), at(j, 1), at(j + 1, 0), at(j, 1), at(j + 1, 1), at(j + 1, 0)})
        p.indices.push_back(k);
    }
  Scene scene;
  scene.materials.push_back(test::matte(glm::vec3(0.5f)));
  test::add(&scene, std::move(p), "bowl");
  return scene;
}

/// Of four texels of the finer cube, their coarser one.
Eigen::Index coarser(Eigen::Index d, Eigen::Index side) {
  return (d / (side * side) * side / 2 + d / side % side / 2) * side / 2 + d % side / 2;
}

struct Lit {
  FlatGeometry geometry;
  TransferMesh mesh;
  CubeDirections cube;
  RayScene scene;
  ArrivingLight arriving;
  std::vector<std::uint32_t> sources;
  Lit(const Scene& from, std::vector<TransferPart> parts, int side)
      : geometry(flatten(from)),
        mesh(make_transfer_mesh(geometry, parts, 0)),
        cube(side),
        scene(build_ray_scene(geometry, std::vector<bool>(geometry.items.size(), true))),
        arriving(trace_arriving_light(mesh, cube, scene, {.rays = 2}, kNever)) {
    for (std::uint32_t v = 0; v < mesh.vertices.size(); ++v) sources.push_back(v);
  }
};

TEST(Bounces, ReflectedSharesAreAlbedos) {
  const auto shares = reflected_shares(*lambert_btf({0.8f, 0.5f, 0.1f}));
  ASSERT_EQ(shares.size(), 3u * 19u);
  for (std::size_t l = 0; l < 19; ++l) {
    EXPECT_NEAR(shares[3 * l], 0.8f, 2e-3f);
    EXPECT_NEAR(shares[3 * l + 1], 0.5f, 2e-3f);
    EXPECT_NEAR(shares[3 * l + 2], 0.1f, 2e-3f);
  }
}

/// Between points of a sphere every form factor is the same, area over that of the sphere: whatever light enters the
/// bowl, n reflections add (albedo f)^n of its mean irradiance, f the bowl's share of the sphere.
TEST(Bounces, InsideOfABowlHasItsClosedForm) {
  constexpr double kOpen = 1.0;
  const double f = 0.5 * (1.0 + std::cos(kOpen));
  const Lit s(bowl(kOpen, 16, 24), {{.item = 0}}, 16);
  const glm::dvec3 albedo(0.9, 0.6, 0.2);
  const std::vector<std::shared_ptr<const Btf>> materials{lambert_btf(glm::vec3(albedo))};
  // Mean irradiance over the area, by direction of the coarse cube, in double.
  const CubeDirections coarse(8);
  Eigen::VectorXd mean = Eigen::VectorXd::Zero(coarse.count());
  double area = 0.0;
  const auto n = s.mesh.vertices.size();
  for (std::size_t v = 0; v < n; ++v) {
    const double theta = std::acos(std::clamp(static_cast<double>(s.mesh.vertices[v].position.y), -1.0, 1.0)),
                 step = (std::numbers::pi - kOpen) / 16.0, low = std::max(theta - 0.5 * step, kOpen),
                 high = std::min(theta + 0.5 * step, std::numbers::pi), own = std::cos(low) - std::cos(high);
    area += own;
    for (std::size_t e = s.arriving.first[v]; e < s.arriving.first[v + 1]; ++e) {
      const auto& entry = s.arriving.entries[e];
      const Eigen::Index d = entry.direction, at = coarser(d, s.cube.side());
      mean[at] += own * static_cast<double>(entry.arriving) * s.cube.solid_angles()[d] / coarse.solid_angles()[at];
    }
  }
  mean /= area;
  ASSERT_GT(mean.maxCoeff(), 0.1);
  for (const int count : {1, 8}) {
    const Bounces bounces =
        compute_bounces({s.mesh, s.geometry, s.scene, s.cube, s.arriving, materials, s.sources}, count, kNever);
    const Eigen::MatrixXf direct = Eigen::MatrixXf::Zero(s.cube.count(), 1);
    for (const std::uint32_t vertex : {40u, 150u, 250u, 380u}) {
      const Eigen::MatrixXf found = add_bounces(direct, bounces, *materials[0]->views[0].lights, {vertex}, {}, 0, 0);
      double squares = 0.0, all = 0.0;
      for (int c = 0; c < 3; ++c) {
        double series = 0.0;
        for (int k = 1; k <= count; ++k) series += std::pow(albedo[c], k) * std::pow(f, k);
        for (Eigen::Index d = 0; d < s.cube.count(); ++d) {
          const double expected = series * mean[coarser(d, s.cube.side())];
          squares += std::pow(static_cast<double>(found(c * s.cube.count() + d, 0)) - expected, 2.0);
          all += expected * expected;
        }
      }
      EXPECT_LT(std::sqrt(squares / all), 0.06) << count << " reflections, vertex " << vertex;
    }
  }
}

/// Two rooms' walls of unlike colours: the sums of the reflections are those of a linear system in double.
TEST(Bounces, AgreeWithALinearSystemBetweenColouredPlates) {
  Scene from;
  from.materials.push_back(test::matte(glm::vec3(0.5f)));
  test::add(&from, test::make_grid({-1, 0, 1}, {2, 0, 0}, {0, 0, -2}, 5, 0), "floor");
  test::add(&from, test::make_grid({-1, 0, -1}, {2, 0, 0}, {0, 2, 0}, 5, 0), "wall");
  const Lit s(from, {{.item = 0, .group = 0}, {.item = 1, .group = 1}}, 8);
  const std::vector<std::shared_ptr<const Btf>> materials{test::small_btf(2, 2), lambert_btf({0.9f, 0.2f, 0.1f})};
  const Bounces bounces =
      compute_bounces({s.mesh, s.geometry, s.scene, s.cube, s.arriving, materials, s.sources}, 16, kNever);
  const auto n = static_cast<Eigen::Index>(s.mesh.vertices.size());
  const std::vector<float> shares[2] = {reflected_shares(*materials[0]), reflected_shares(*materials[1])};
  const CubeDirections coarse(4);
  double energy = 0.0;
  for (int c = 0; c < 3; ++c) {
    const auto share = [&](Eigen::Index v, const glm::vec3& local) {
      const std::uint32_t group = s.mesh.vertices[static_cast<std::size_t>(v)].group;
      const DirectionWeights w = materials[group]->views[0].lights->find(local);
      double sum = 0.0;
      for (std::size_t k = 0; k < 3; ++k)
        sum += static_cast<double>(w.weight[static_cast<int>(k)]) *
               static_cast<double>(shares[group][static_cast<std::size_t>(3 * w.index[k] + c)]);
      return sum / std::numbers::pi;
    };
    Eigen::MatrixXd system = Eigen::MatrixXd::Identity(n, n), first = Eigen::MatrixXd::Zero(n, coarse.count());
    for (Eigen::Index v = 0; v < n; ++v) {
      const auto t = static_cast<std::size_t>(v);
      for (std::size_t e = bounces.gathered.first[t]; e < bounces.gathered.first[t + 1]; ++e) {
        const auto& entry = bounces.gathered.entries[e];
        system(v, entry.source) -= static_cast<double>(entry.weight) * share(v, entry.local);
        energy += static_cast<double>(entry.weight);
      }
      for (std::size_t e = s.arriving.first[t]; e < s.arriving.first[t + 1]; ++e) {
        const auto& entry = s.arriving.entries[e];
        const Eigen::Index d = entry.direction, at = coarser(d, s.cube.side());
        first(v, at) += static_cast<double>(entry.arriving) * s.cube.solid_angles()[d] / coarse.solid_angles()[at] *
                        share(v, entry.local);
      }
    }
    const Eigen::MatrixXd expected = system.partialPivLu().solve(first);
    const Eigen::MatrixXd found =
        bounces.sent.middleRows(c * coarse.count(), coarse.count()).transpose().cast<double>();
    EXPECT_LT((found - expected).norm() / expected.norm(), 1e-4) << c;
    EXPECT_GT((found - first).norm() / expected.norm(), 0.02) << c;
  }
  EXPECT_GT(energy, 10.0);
}

TEST(Bounces, TransferByColourKeepsItsColours) {
  const CubeDirections cube(4);
  Eigen::MatrixXf transfer = Eigen::MatrixXf::Random(3 * cube.count(), 30).cwiseAbs();
  const TransferMatrix m = factorise_transfer(transfer, cube, {.clusters = 2, .components = 20});
  EXPECT_EQ(m.channels, 3);
  EXPECT_LT((decode_transfer(m, cube) - transfer).norm() / transfer.norm(), 0.002);
  RelightTable table(4, m.rows(), 3);
  table.add(m);
  CubeLight light = CubeLight::Random(cube.count(), 3), haar = light;
  for (int c = 0; c < 3; ++c) haar_transform_faces(4, haar.col(c).data());
  const KeptLight kept = choose_coefficients(haar, table.importance(), table.coefficients());
  std::vector<glm::vec4> sums, plain;
  table.sums(kept, &sums);
  table.sums_by_scalars(kept, &plain);
  const Eigen::VectorXd solid = cube.solid_angles();
  for (std::size_t row = 0; row < m.rows(); ++row) EXPECT_EQ(sums[row], plain[row]);
  // A vertex' sum: by colour, the transfer of that colour times its light.
  const auto terms = static_cast<std::size_t>(1 + m.components);
  for (std::size_t v = 0; v < 30; v += 7) {
    const Eigen::MatrixXf decoded = decode_transfer(m, cube);
    glm::dvec3 found(sums[m.owner[v] * terms]);
    for (std::size_t c = 1; c < terms; ++c)
      found += static_cast<double>(float_of_half(m.weights[v * (terms - 1) + c - 1])) *
               glm::dvec3(sums[m.owner[v] * terms + c]);
    for (int c = 0; c < 3; ++c) {
      double expected = 0.0;
      for (Eigen::Index d = 0; d < cube.count(); ++d)
        expected += static_cast<double>(decoded(c * cube.count() + d, static_cast<Eigen::Index>(v))) * solid[d] *
                    static_cast<double>(light(d, c));
      EXPECT_NEAR(found[c], expected, 0.01 * std::abs(expected) + 0.01) << v << " " << c;
    }
  }
}

}  // namespace
}  // namespace maquette
