#include "render/prt/joint_transfer.h"

#include <gtest/gtest.h>

#include <Eigen/SVD>
#include <array>
#include <cmath>

#include "render/prt/joint_btf.h"
#include "render/prt/relight.h"
#include "render/prt/transfer.h"
#include "scenes/btf/half_floats.h"
#include "tests/support/never.h"
#include "tests/support/small_btf.h"

namespace maquette {
namespace {

glm::vec3 local_direction(int i) {
  const double z = (i % 7 + 0.5) / 7.0, phi = 2.4 * i, r = std::sqrt(1.0 - z * z);
  return glm::vec3(r * std::cos(phi), r * std::sin(phi), z);
}

glm::vec3 rho_of(const Btf& btf, int texel, std::size_t view, const glm::vec3& wi) {
  const glm::vec2 uv((static_cast<float>(texel % btf.width) + 0.5f) / static_cast<float>(btf.width),
                     (static_cast<float>(texel / btf.width) + 0.5f) / static_cast<float>(btf.height));
  return evaluate_btf(btf, {uv, 0.0f}, wi, glm::vec3(btf.views[view].direction));
}

TEST(JointBtf, WithAFunctionForEveryColourIsTheBtf) {
  // Of each texel a cluster, and of each cluster as many functions as a texel has colours.
  const auto btf = test::small_btf(2, 2);
  const auto joint = fit_joint_btf(*btf, {.clusters = 4, .components = 2}, kNever);
  ASSERT_EQ(joint->clusters, 4);
  EXPECT_LT(joint->error, 1e-3);
  for (int texel = 0; texel < 4; ++texel)
    for (std::size_t view = 0; view < 19; view += 3)
      for (int i = 0; i < 20; ++i) {
        const glm::vec3 wi = local_direction(i), expected = glm::max(rho_of(*btf, texel, view, wi), glm::vec3(0.0f)),
                        found = glm::max(evaluate_joint_btf(*joint, *btf, texel, view, wi), glm::vec3(0.0f));
        EXPECT_LT(glm::length(found - expected), 3e-3f * glm::length(expected) + 1e-4f) << texel << " " << view;
      }
}

TEST(JointBtf, ErrorIsThatOfPlainSumsAndFallsWithClusters) {
  const auto btf = test::small_btf(4, 2);
  double last = 1.0;
  for (const int clusters : {1, 2, 4, 8}) {
    const auto joint = fit_joint_btf(*btf, {.clusters = clusters, .components = 1}, kNever);
    double lost = 0.0, all = 0.0;
    for (std::size_t view = 0; view < btf->views.size(); ++view) {
      const DirectionMesh& lights = *btf->views[view].lights;
      const std::vector<double> shares = lights.quadrature().projected;
      for (std::size_t l = 0; l < shares.size(); ++l)
        for (int texel = 0; texel < 16; ++texel) {
          const glm::vec3 wi(lights.directions()[l]);
          std::vector<glm::vec3> factors(3);
          read_btf_factors(
              *btf, btf->views[view],
              {{(static_cast<float>(texel % 4) + 0.5f) / 4.0f, (static_cast<float>(texel / 4) + 0.5f) / 4.0f}, 0.0f},
              factors.data());
          glm::dvec3 rho(factors[0]);
          for (std::size_t c = 0; c < 2; ++c)
            rho += static_cast<double>(btf->views[view].light_weights[2 * l + c]) * glm::dvec3(factors[c + 1]);
          const glm::dvec3 left = rho - glm::dvec3(evaluate_joint_btf(*joint, *btf, texel, view, wi));
          lost += shares[l] * glm::dot(left, left);
          all += shares[l] * glm::dot(rho, rho);
        }
    }
    EXPECT_NEAR(joint->error, std::sqrt(lost / all), 0.02 * joint->error + 1e-4) << clusters;
    EXPECT_LT(joint->error, last);
    last = joint->error;
  }
  EXPECT_LT(last, 0.05);
}

TEST(JointBtf, StandsBlackAndEqualTexelsAndOneViewOrTexel) {
  Btf black = *test::small_btf(2, 2);
  for (BtfView& view : black.views) std::fill(view.factors.begin(), view.factors.end(), std::uint16_t{0});
  const auto none = fit_joint_btf(black, {}, kNever);
  EXPECT_EQ(none->error, 0.0);
  for (const auto& functions : none->functions)
    for (const float f : functions) EXPECT_TRUE(std::isfinite(f));
  for (const auto& btf : {test::small_btf(1, 2), test::small_btf(4, 2, {direction_of_angles(40.0, 10.0)})}) {
    const auto joint = fit_joint_btf(*btf, {.clusters = 8, .components = 4}, kNever);
    EXPECT_LE(joint->clusters, btf->width * btf->height);
    EXPECT_LT(joint->error, 2e-3);
  }
  const std::atomic<bool> at_once{true};
  EXPECT_EQ(fit_joint_btf(*test::small_btf(2, 2), {}, at_once), nullptr);
}

/// Smooth functions of a vertex, views and directions.
struct SmoothTransfer {
  CubeDirections cube{4};
  std::size_t views = 9;
  int vertices = 120;
  Eigen::MatrixXf operator()(std::size_t view) const {
    Eigen::MatrixXf t(cube.count(), vertices);
    for (int i = 0; i < vertices; ++i) {
      const double z = 1.0 - 1.6 * (i + 0.5) / vertices, phi = 2.39996 * i, r = std::sqrt(1.0 - z * z);
      const glm::dvec3 n(r * std::cos(phi), z, r * std::sin(phi));
      for (Eigen::Index d = 0; d < cube.count(); ++d) {
        const double cosine = glm::dot(n, cube.direction(d));
        t(d, i) = cosine > 0.0 && cube.direction(d).x + 0.2 * n.y > -0.5
                      ? static_cast<float>(cosine * (1.0 + std::pow(cosine, 2.0 + static_cast<double>(view))))
                      : 0.0f;
      }
    }
    return t;
  }
};

double joint_error(const std::vector<TransferMatrix>& joint) {
  double squares = 0.0, energy = 0.0;
  for (const TransferMatrix& m : joint) {
    energy += m.energy * static_cast<double>(m.squares.size());
    for (const float s : m.squares) squares += static_cast<double>(s);
  }
  return std::sqrt(squares / energy);
}

TEST(JointTransfer, IsCloseToTheBestSubspaceOfAllViewsTogether) {
  const SmoothTransfer transfer;
  const Eigen::VectorXd roots = transfer.cube.solid_angles().cwiseSqrt();
  Eigen::MatrixXd stacked(static_cast<Eigen::Index>(transfer.views) * transfer.cube.count(), transfer.vertices);
  for (std::size_t v = 0; v < transfer.views; ++v)
    stacked.middleRows(static_cast<Eigen::Index>(v) * transfer.cube.count(), transfer.cube.count()) =
        roots.asDiagonal() * transfer(v).cast<double>();
  const double all = stacked.squaredNorm();
  const Eigen::VectorXd mean = stacked.rowwise().mean();
  const Eigen::VectorXd values = Eigen::BDCSVD<Eigen::MatrixXd>(stacked.colwise() - mean).singularValues();
  for (const int components : {1, 3, 6, 12}) {
    const auto joint = factorise_joint_transfer([&](std::size_t v) { return transfer(v); }, transfer.views,
                                                transfer.cube, {.clusters = 1, .components = components});
    const double best = std::sqrt(values.tail(values.size() - components).squaredNorm() / all);
    EXPECT_GE(joint_error(joint), 0.999 * best);
    EXPECT_LT(joint_error(joint), 1.08 * best) << components;
  }
  // More clusters, less error; and the error is that of what is decoded.
  double last = 1.0;
  for (const int clusters : {1, 2, 4}) {
    const auto joint = factorise_joint_transfer([&](std::size_t v) { return transfer(v); }, transfer.views,
                                                transfer.cube, {.clusters = clusters, .components = 4});
    double left = 0.0;
    for (std::size_t v = 0; v < transfer.views; ++v)
      left += (roots.cast<float>().asDiagonal() * (decode_joint_transfer(joint, v, transfer.cube) - transfer(v)))
                  .cast<double>()
                  .squaredNorm();
    EXPECT_NEAR(std::sqrt(left / all), joint_error(joint), 0.02 * joint_error(joint) + 5e-4);
    EXPECT_LT(joint_error(joint), last);
    last = joint_error(joint);
  }
}

TEST(JointTransfer, AtFullRankEqualsPlainSums) {
  // A material in joint form on vertices with transfer of their own, against sums over directions in double.
  const auto btf = test::small_btf(2, 2);
  const auto joint = fit_joint_btf(*btf, {.clusters = 2, .components = 2}, kNever);
  const CubeDirections cube(4);
  constexpr int kVertices = 20;
  ArrivingLight arriving;
  arriving.first.push_back(0);
  std::vector<std::uint32_t> all;
  for (int v = 0; v < kVertices; ++v) {
    all.push_back(static_cast<std::uint32_t>(v));
    for (int d = 0; d < cube.count(); ++d)
      if ((d * 7 + v * 3) % 5 != 0)
        arriving.entries.push_back(
            {static_cast<std::uint16_t>(d), 0.1f + 0.01f * static_cast<float>((d + v) % 60), local_direction(d + v)});
    arriving.first.push_back(arriving.entries.size());
  }
  const LightTable table(arriving, all, btf->views[0].lights);
  CubeLight light(cube.count(), 3);
  for (Eigen::Index d = 0; d < cube.count(); ++d)
    light.row(d) << static_cast<float>(1.0 + cube.direction(d).y), 0.7f, static_cast<float>(d % 11 == 0 ? 30.0 : 0.5);
  CubeLight haar = light;
  for (int c = 0; c < 3; ++c) haar_transform_faces(4, haar.col(c).data());
  double squares = 0.0, sum = 0.0;
  int count = 0;
  std::vector<std::vector<TransferMatrix>> functions;
  for (int f = 0; f < static_cast<int>(joint->function_count()); ++f)
    functions.push_back(factorise_joint_transfer(
        [&](std::size_t v) {
          return table.transfer(cube.count(), joint->functions[v], static_cast<int>(joint->function_count()), f);
        },
        btf->views.size(), cube, {.clusters = 1, .components = kVertices}));
  for (const std::size_t view : {std::size_t{0}, std::size_t{5}, std::size_t{18}}) {
    std::vector<std::vector<glm::vec4>> sums;
    for (const auto& function : functions) {
      RelightTable relight(4, function[view].rows());
      relight.add(function[view]);
      sums.emplace_back();
      relight.sums(choose_coefficients(haar, relight.importance(), relight.coefficients()), &sums.back());
    }
    for (std::size_t v = 0; v < kVertices; v += 3)
      for (int texel = 0; texel < 4; ++texel) {
        const std::uint16_t* halves = joint->texels.data() + static_cast<std::size_t>(texel) * joint->texel_halves();
        const auto cluster = static_cast<std::size_t>(float_of_half(halves[0]));
        glm::dvec3 found(0.0), expected(0.0);
        for (std::size_t c = 0; c < 3; ++c) {
          const std::size_t f = cluster * 3 + c;
          glm::dvec3 own(sums[f][0]);
          for (std::size_t k = 0; k < kVertices; ++k)
            own += static_cast<double>(float_of_half(functions[f][0].weights[v * kVertices + k])) *
                   glm::dvec3(sums[f][k + 1]);
          for (int n = 0; n < 3; ++n)
            found[n] += own[n] * static_cast<double>(float_of_half(halves[1 + 3 * c + static_cast<std::size_t>(n)]));
        }
        for (std::size_t e = arriving.first[v]; e < arriving.first[v + 1]; ++e) {
          const auto& entry = arriving.entries[e];
          const glm::dvec3 rho(evaluate_joint_btf(*joint, *btf, texel, view, entry.local));
          expected += static_cast<double>(entry.arriving) * cube.solid_angles()[entry.direction] * rho *
                      glm::dvec3(light(entry.direction, 0), light(entry.direction, 1), light(entry.direction, 2));
        }
        squares += glm::dot(found - expected, found - expected);
        sum += expected.x + expected.y + expected.z;
        count += 3;
      }
  }
  EXPECT_LT(std::sqrt(squares / count) / (sum / count), 0.005);
}

TEST(JointTransfer, StandsBlackFewAndEqualVertices) {
  const CubeDirections cube(4);
  const auto of = [&](const Eigen::MatrixXf& t) {
    return factorise_joint_transfer([&](std::size_t) { return t; }, 3, cube, {.clusters = 8, .components = 3});
  };
  for (const TransferMatrix& m : of(Eigen::MatrixXf::Zero(96, 30)))
    for (const std::uint16_t q : m.q) EXPECT_EQ(q & 0x7fff, 0);
  const Eigen::MatrixXf few = Eigen::MatrixXf::Random(96, 3);
  const Eigen::MatrixXf equal = few.col(0).replicate(1, 40);
  const Eigen::MatrixXf rank_one = few.col(0) * Eigen::RowVectorXf::LinSpaced(40, 0.1f, 2.0f);
  for (const Eigen::MatrixXf& t : {few, equal, rank_one}) {
    const auto joint = of(t);
    ASSERT_EQ(joint.size(), 3u);
    EXPECT_EQ(joint[2].clusters, 8);
    EXPECT_LT((decode_joint_transfer(joint, 2, cube) - t).norm() / t.norm(), 0.003);
  }
}

}  // namespace
}  // namespace maquette
