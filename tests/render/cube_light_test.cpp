#include "render/prt/cube_light.h"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <random>

#include "render/prt/relight.h"
#include "scenes/btf/half_floats.h"
#include "tests/support/sparse_transfer.h"

namespace maquette {
namespace {

Environment smooth_sky() {
  Environment sky;
  sky.width = 64;
  sky.height = 32;
  for (int y = 0; y < sky.height; ++y)
    for (int x = 0; x < sky.width; ++x) {
      const glm::dvec3 d = direction_from_latlong(x + 0.5, y + 0.5, sky.width, sky.height);
      sky.rgb.emplace_back(1.0 + d.x, 1.5 + d.y * d.z, 1.0 + 0.5 * std::sin(3.0 * d.z + d.x));
    }
  return sky;
}

Environment sunny_sky(const glm::dvec3& towards) {
  Environment sky = smooth_sky();
  sky.width = 256;
  sky.height = 128;
  sky.rgb.assign(256 * 128, glm::vec3(0.2f));
  for (int y = 0; y < sky.height; ++y)
    for (int x = 0; x < sky.width; ++x)
      if (glm::dot(direction_from_latlong(x + 0.5, y + 0.5, 256, 128), glm::normalize(towards)) > std::cos(0.05))
        sky.rgb[static_cast<std::size_t>(y * 256 + x)] = glm::vec3(300.0f, 250.0f, 200.0f);
  return sky;
}

/// The light of each texel, by 24 x 24 points of the environment itself.
CubeLight slow_light(const Environment& sky, const CubeDirections& cube, const glm::dmat3& environment_from_cube) {
  CubeLight light(cube.count(), 3);
  constexpr int kPoints = 24;
  for (Eigen::Index i = 0; i < cube.count(); ++i) {
    glm::dvec3 sum(0.0);
    double weights = 0.0;
    for (int p = 0; p < kPoints * kPoints; ++p) {
      const glm::dvec3 d = cube.direction_within(i, {(p % kPoints + 0.5) / kPoints, (p / kPoints + 0.5) / kPoints});
      const double weight = std::pow(cube_point(d).face < 2   ? std::abs(d.x)
                                     : cube_point(d).face < 4 ? std::abs(d.y)
                                                              : std::abs(d.z),
                                     3.0);
      sum += weight * evaluate_environment(sky, environment_from_cube * d);
      weights += weight;
    }
    for (int c = 0; c < 3; ++c) light(i, c) = static_cast<float>(sum[c] / weights);
  }
  return light;
}

double relative_difference(const CubeLight& a, const CubeLight& b, const CubeDirections& cube) {
  double squares = 0.0, all = 0.0;
  for (Eigen::Index i = 0; i < cube.count(); ++i)
    for (int c = 0; c < 3; ++c) {
      squares += cube.solid_angles()[i] * std::pow(static_cast<double>(a(i, c) - b(i, c)), 2.0);
      all += cube.solid_angles()[i] * std::pow(static_cast<double>(b(i, c)), 2.0);
    }
  return std::sqrt(squares / all);
}

TEST(CubeDirections, SolidAnglesFillTheSphere) {
  for (const int side : {1, 2, 8, 16, 32}) {
    const CubeDirections cube(side);
    EXPECT_NEAR(cube.solid_angles().sum(), 4.0 * std::numbers::pi, 1e-10);
    // The formula of a texel's middle, which is 0.1 % high at 16 x 16.
    const double u = 1.0 / side, middle = 4.0 / (side * side * std::pow(1.0 + 2.0 * u * u, 1.5));
    if (side > 8) {
      EXPECT_NEAR(cube.solid_angles()[(side / 2) * side + side / 2], middle, 0.01 * middle);
    }
    for (Eigen::Index i = 0; i < cube.count(); ++i) {
      const CubePoint p = cube_point(cube.direction(i));
      EXPECT_EQ(p.face, i / (side * side));
      EXPECT_NEAR(glm::length(glm::normalize(cube_direction(p.face, p.u, p.v)) - cube.direction(i)), 0.0, 1e-12);
      EXPECT_NEAR(glm::length(cube.direction_within(i, {0.5, 0.5}) - cube.direction(i)), 0.0, 1e-12);
    }
  }
}

TEST(CubePyramid, GivesTheMeanOfEachTexelUnderAnyRotation) {
  const CubeDirections cube(16);
  const glm::dvec3 axis = glm::normalize(glm::dvec3(0.3, 0.8, -0.5));
  const double angle = 25.0 * std::numbers::pi / 180.0;
  glm::dmat3 tilted{1.0};
  for (int k = 0; k < 3; ++k) {
    glm::dvec3 e(0.0);
    e[k] = 1.0;
    tilted[k] = e * std::cos(angle) + glm::cross(axis, e) * std::sin(angle) +
                axis * glm::dot(axis, e) * (1.0 - std::cos(angle));
  }
  for (const glm::dmat3& turn : {glm::dmat3(1.0), environment_rotation(37.0 * std::numbers::pi / 180.0), tilted}) {
    EXPECT_LT(
        relative_difference(CubePyramid(smooth_sky()).resample(cube, turn), slow_light(smooth_sky(), cube, turn), cube),
        2e-3);
    // A sun of 3 degrees half angle moves within texels of 6 degrees.
    const Environment sky = sunny_sky({0.2, 0.5, 0.7});
    EXPECT_LT(relative_difference(CubePyramid(sky).resample(cube, turn), slow_light(sky, cube, turn), cube), 0.1);
  }
}

TEST(CubePyramid, TheSunKeepsItsEnergyWhereverItStands) {
  const CubeDirections cube(16);
  // On an edge, in a corner, and in the middle of a face.
  for (const glm::dvec3& towards :
       {glm::dvec3(1, 0, 1), glm::dvec3(1, 1, 1), glm::dvec3(0.01, 1, 0.02), glm::dvec3(-1, 0.3, 1)}) {
    const Environment sky = sunny_sky(towards);
    double expected = 0.0;
    for (int y = 0; y < sky.height; ++y) {
      const double row =
          2.0 * std::numbers::pi / sky.width *
          (std::cos(std::numbers::pi * y / sky.height) - std::cos(std::numbers::pi * (y + 1) / sky.height));
      for (int x = 0; x < sky.width; ++x)
        expected += row * static_cast<double>(sky.rgb[static_cast<std::size_t>(y * sky.width + x)].x);
    }
    const CubePyramid pyramid(sky);
    for (const double degrees : {0.0, 0.1, 17.0, 37.0, 90.0}) {
      const CubeLight light = pyramid.resample(cube, environment_rotation(degrees * std::numbers::pi / 180.0));
      EXPECT_NEAR(light.col(0).cast<double>().dot(cube.solid_angles()), expected, 0.02 * expected) << degrees;
    }
  }
}

TEST(CubePyramid, ConstantLightStaysConstant) {
  Environment sky = smooth_sky();
  sky.rgb.assign(sky.rgb.size(), glm::vec3(3.0f));
  const CubeLight light = CubePyramid(sky).resample(CubeDirections(8), environment_rotation(0.3));
  for (Eigen::Index i = 0; i < light.rows(); ++i) EXPECT_NEAR(light(i, 1), 3.0f, 1e-5f);
}

TEST(EnvironmentRotation, IsPositiveFromZToX) {
  // The environment's +Z is seen at +X after a quarter turn.
  const glm::dvec3 seen = environment_rotation(0.5 * std::numbers::pi) * glm::dvec3(1.0, 0.0, 0.0);
  EXPECT_NEAR(glm::length(seen - glm::dvec3(0.0, 0.0, 1.0)), 0.0, 1e-12);
}

/// Value at (x, y) of the basis function whose coefficient stands at (i, j): products of one-dimensional functions of
/// one level.
double basis_value(int side, int i, int j, int x, int y) {
  int n = 1;
  while (n <= std::max(i, j)) n *= 2;
  if (n == 1) return 1.0 / side;
  const int half = n / 2, support = side / half;
  const auto factor = [&](int index, int at) {
    const bool wavelet = index >= half;
    const int k = wavelet ? index - half : index;
    if (at / support != k) return 0.0;
    return wavelet && at % support >= support / 2 ? -1.0 : 1.0;
  };
  return factor(i, x) * factor(j, y) / support;
}

TEST(HaarFaces, AreInnerProductsWithTheBasis) {
  constexpr int kSide = 8;
  std::mt19937 random(4);
  std::vector<float> values(6 * kSide * kSide), coefficients;
  for (float& v : values) v = std::uniform_real_distribution<float>(-1.0f, 3.0f)(random);
  coefficients = values;
  haar_transform_faces(kSide, coefficients.data());
  for (int face = 0; face < 6; ++face)
    for (int j = 0; j < kSide; ++j)
      for (int i = 0; i < kSide; ++i) {
        double expected = 0.0;
        for (int y = 0; y < kSide; ++y)
          for (int x = 0; x < kSide; ++x)
            expected += basis_value(kSide, i, j, x, y) *
                        static_cast<double>(values[static_cast<std::size_t>((face * kSide + y) * kSide + x)]);
        EXPECT_NEAR(coefficients[static_cast<std::size_t>((face * kSide + j) * kSide + i)], expected, 1e-5)
            << i << " " << j;
      }
  inverse_haar_faces(kSide, coefficients.data());
  for (std::size_t k = 0; k < values.size(); ++k) EXPECT_NEAR(coefficients[k], values[k], 1e-5f);
}

TEST(KeptLight, TakesTheLargestProductsOfAllFaces) {
  CubeLight light = CubeLight::Random(6 * 16, 3);
  std::mt19937 random(9);
  std::vector<float> importance;
  for (int i = 0; i < 96; ++i) importance.push_back(std::uniform_real_distribution<float>(0.0f, 1.0f)(random));
  const KeptLight kept = choose_coefficients(light, importance, 20);
  ASSERT_EQ(kept.coefficients.size(), 20u);
  float least = 1e9f, most_left_out = 0.0f;
  for (std::uint32_t i = 0; i < 96; ++i) {
    const float worth = light.row(i).cwiseAbs().maxCoeff() * importance[i];
    const bool in = std::binary_search(kept.coefficients.begin(), kept.coefficients.end(), i);
    if (in)
      least = std::min(least, worth);
    else
      most_left_out = std::max(most_left_out, worth);
  }
  EXPECT_GE(least, most_left_out);
  EXPECT_TRUE(choose_coefficients(CubeLight::Zero(96, 3), importance, 20).coefficients.empty());
  // One hot texel lights all coefficients above it, and no others.
  CubeLight hot = CubeLight::Zero(96, 3);
  hot(5, 0) = 1e6f;
  haar_transform_faces(4, hot.col(0).data());
  EXPECT_EQ(choose_coefficients(hot, std::vector<float>(96, 1.0f), 96).coefficients.size(), 1u + 3u * 2u);
}

TEST(KeptLight, ChangesSteadilyWithTheLight) {
  const CubeLight a = CubeLight::Random(96, 3), b = CubeLight::Random(96, 3);
  std::mt19937 random(9);
  std::vector<float> importance;
  for (int i = 0; i < 96; ++i) importance.push_back(std::uniform_real_distribution<float>(0.1f, 1.0f)(random));
  const auto kept_at = [&](float angle) {
    const KeptLight kept = choose_coefficients(std::cos(angle) * a + std::sin(angle) * b, importance, 20);
    CubeLight light = CubeLight::Zero(96, 3);
    for (std::size_t k = 0; k < kept.coefficients.size(); ++k)
      for (int c = 0; c < 3; ++c) light(kept.coefficients[k], c) = importance[kept.coefficients[k]] * kept.values[k][c];
    return light;
  };
  constexpr float kStep = 1e-3f;
  float largest = 0.0f, exchanged = 0.0f;
  CubeLight last = kept_at(0.0f);
  for (int i = 1; i <= 1500; ++i) {
    const CubeLight now = kept_at(kStep * static_cast<float>(i));
    largest = std::max(largest, (now - last).cwiseAbs().maxCoeff());
    for (Eigen::Index k = 0; k < 96; ++k) exchanged += (now.row(k).isZero() != last.row(k).isZero()) ? 1.0f : 0.0f;
    last = now;
  }
  EXPECT_GT(exchanged, 20.0f);
  EXPECT_LT(largest, 12.0f * kStep) << "what appears or goes has about 0.5";
}

TEST(KeptLight, StandsCoefficientsOfTheSameWorth) {
  // None of them is better than the best that is left away.
  const KeptLight kept = choose_coefficients(CubeLight::Ones(96, 3), std::vector<float>(96, 1.0f), 20);
  ASSERT_EQ(kept.values.size(), 20u);
  for (const glm::vec3& v : kept.values) EXPECT_EQ(v, glm::vec3(1.0f));
}

TEST(RelightTable, SumsAreThoseOfPlainProducts) {
  std::mt19937 random(11);
  std::normal_distribution<float> normal(0.0f, 0.02f);
  constexpr int kSide = 4;
  RelightTable table(kSide, 3 * 250);
  std::vector<TransferMatrix> matrices(3);
  for (TransferMatrix& m : matrices) {
    m.clusters = 50;
    m.components = 4;
    for (std::size_t i = 0; i < m.rows() * 96; ++i) m.q.push_back(half_of_float(normal(random)));
    for (int v = 0; v < 70; ++v) m.owner.push_back(static_cast<std::uint16_t>(v % 50));
    m.weights.assign(70 * 4, 0);
  }
  for (std::size_t k = 0; k < 3; ++k) EXPECT_EQ(table.add(matrices[k]), 250 * k);
  const CubeLight light = CubeLight::Random(96, 3);
  const KeptLight kept = choose_coefficients(light, table.importance(), 60);
  std::vector<glm::vec4> fast, plain;
  table.sums(kept, &fast);
  table.sums_by_scalars(kept, &plain);
  ASSERT_EQ(fast.size(), 750u);
  for (std::size_t row = 0; row < fast.size(); ++row) {
    EXPECT_EQ(fast[row], plain[row]);
    for (int c = 0; c < 3; ++c) {
      double expected = 0.0;
      for (std::size_t k = 0; k < kept.coefficients.size(); ++k)
        expected += static_cast<double>(float_of_half(matrices[row / 250].q[kept.coefficients[k] * 250 + row % 250])) *
                    static_cast<double>(kept.values[k][c]);
      EXPECT_NEAR(fast[row][c], expected, 1e-5);
    }
  }
}

TEST(SparseTransfer, IsTheWholeTableWithAllCoefficientsAndNearerToItWithMore) {
  std::mt19937 random(12);
  std::normal_distribution<float> normal(0.0f, 0.02f);
  TransferMatrix matrix;
  matrix.clusters = 100;
  matrix.components = 2;
  for (std::size_t i = 0; i < matrix.rows() * 96; ++i)
    matrix.q.push_back(half_of_float(std::pow(10.0f * normal(random), 3.0f)));  // a few large values
  for (int v = 0; v < 100; ++v) matrix.owner.push_back(static_cast<std::uint16_t>(v));
  matrix.weights.assign(200, 0);
  RelightTable table(4, matrix.rows());
  table.add(matrix);
  const KeptLight kept = choose_coefficients(CubeLight::Random(96, 3), table.importance(), 60);
  std::vector<glm::vec4> whole, sparse;
  table.sums(kept, &whole);
  double last_error = 1.0, last_distance = 1e9;
  for (const std::size_t count : {std::size_t{8}, std::size_t{32}, std::size_t{96}}) {
    const test::SparseTransfer transfer(table, count);
    transfer.sums(kept, &sparse);
    ASSERT_EQ(sparse.size(), whole.size());
    double distance = 0.0;
    for (std::size_t r = 0; r < whole.size(); ++r)
      distance = std::max(distance, static_cast<double>(glm::length(sparse[r] - whole[r])));
    EXPECT_LT(transfer.error(), last_error);
    EXPECT_LT(distance, last_distance);
    EXPECT_LE(transfer.bytes(), matrix.rows() * count * 4 + (matrix.rows() + 1) * 4);
    last_error = transfer.error(), last_distance = distance;
  }
  EXPECT_EQ(last_error, 0.0);
  EXPECT_LT(last_distance, 1e-5);
}

}  // namespace
}  // namespace maquette
