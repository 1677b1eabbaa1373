#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <cmath>
#include <numbers>
#include <random>

#include "render/math/local_pca_fit.h"

namespace maquette {
namespace {

Eigen::MatrixXf random_matrix(Eigen::Index rows, Eigen::Index columns, unsigned seed) {
  std::mt19937 random(seed);
  std::normal_distribution<float> normal;
  Eigen::MatrixXf m(rows, columns);
  for (Eigen::Index i = 0; i < m.size(); ++i) m.data()[i] = normal(random);
  return m;
}

/// `clusters` affine subspaces of `rank` dimensions, `spread` apart, with noise; the columns of one cluster are
/// consecutive.
Eigen::MatrixXf flats(int dimension, int clusters, int rank, int each, float noise) {
  Eigen::MatrixXf all(dimension, clusters * each);
  for (int k = 0; k < clusters; ++k) {
    const auto seed = static_cast<unsigned>(10 * k);
    const Eigen::VectorXf mean = 3.0f * random_matrix(dimension, 1, seed + 1);
    all.middleCols(k * each, each) = random_matrix(dimension, rank, seed + 2) * random_matrix(rank, each, seed + 3) +
                                     noise * random_matrix(dimension, each, seed + 4);
    all.middleCols(k * each, each).colwise() += mean;
  }
  return all;
}

double mean_error(const LocalPca& pca, const Eigen::MatrixXf& x) {
  double sum = 0.0;
  for (Eigen::Index i = 0; i < x.cols(); ++i) sum += pca.error(x.col(i));
  return sum / static_cast<double>(x.cols());
}

TEST(LocalPca, OneClusterIsTheSingularValueDecomposition) {
  const Eigen::MatrixXf x = random_matrix(20, 6, 1) * random_matrix(6, 200, 2) + 0.1f * random_matrix(20, 200, 3);
  for (int components : {0, 1, 3, 6}) {
    const LocalPca pca = LocalPca::fit(x, {}, {.clusters = 1, .components = components});
    const Eigen::MatrixXd centred = x.cast<double>().colwise() - x.cast<double>().rowwise().mean().eval();
    const Eigen::VectorXd s = Eigen::JacobiSVD<Eigen::MatrixXd>(centred).singularValues();
    const double expected = s.tail(s.size() - components).squaredNorm() / 200.0;
    EXPECT_NEAR(mean_error(pca, x), expected, 1e-4 * expected) << components;
  }
}

/// Tall and wide matrices, and sizes where the eigenvectors are computed from random projections.
TEST(LocalPca, EverySizeFindsTheSameSubspace) {
  for (const auto& [rows, columns] : {std::pair{300, 40}, std::pair{40, 300}, std::pair{1100, 1200}}) {
    const Eigen::MatrixXf x =
        random_matrix(rows, 3, 5) * random_matrix(3, columns, 6) + 0.01f * random_matrix(rows, columns, 7);
    const LocalPca pca = LocalPca::fit(x, {}, {.clusters = 1, .components = 3});
    // The residual is the noise, minus the three directions that were fitted to it.
    const double noise = 1e-4 * static_cast<double>(rows);
    EXPECT_NEAR(mean_error(pca, x), noise, 0.15 * noise) << rows;
    const Eigen::MatrixXf b = pca.components(0);
    EXPECT_LT((b.transpose() * b - Eigen::MatrixXf::Identity(3, 3)).norm(), 1e-4f) << rows;
  }
}

TEST(LocalPca, FindsClustersThatAreFlats) {
  const Eigen::MatrixXf x = flats(24, 6, 2, 80, 0.01f);
  const LocalPca pca = LocalPca::fit(x, {}, {.clusters = 6, .components = 2});
  ASSERT_EQ(pca.cluster_count(), 6);
  EXPECT_LT(mean_error(pca, x), 2.0 * 24.0 * 1e-4);
  int apart = 0;
  for (int k = 0; k < 6; ++k)
    for (int i = 1; i < 80; ++i) apart += pca.encode(x.col(80 * k)).cluster != pca.encode(x.col(80 * k + i)).cluster;
  EXPECT_EQ(apart, 0);
  // A single PCA with as many weights cannot do this: it needs the clusters.
  const LocalPca global = LocalPca::fit(x, {}, {.clusters = 1, .components = 2});
  EXPECT_GT(mean_error(global, x), 100.0 * mean_error(pca, x));
}

TEST(LocalPca, TheErrorNeverGrows) {
  const Eigen::MatrixXf x = flats(16, 9, 3, 40, 0.2f);
  const LocalPca pca = LocalPca::fit(x, {}, {.clusters = 5, .components = 2, .rounds = 30, .least_gain = 0.0});
  ASSERT_GT(pca.history().size(), 2u);
  for (std::size_t i = 1; i < pca.history().size(); ++i)
    EXPECT_LE(pca.history()[i], pca.history()[i - 1] * (1.0 + 1e-5)) << i;
}

/// Each solid angle counts once: splitting a dimension into two halves of its measure changes nothing.
TEST(LocalPca, SplittingADimensionChangesNothing) {
  const Eigen::MatrixXf x = flats(8, 3, 2, 60, 0.1f);
  Eigen::VectorXf measure(8);
  for (int i = 0; i < 8; ++i) measure[i] = 0.5f + 0.25f * static_cast<float>(i);
  Eigen::MatrixXf split(9, x.cols());
  split << x, x.bottomRows(1);
  Eigen::VectorXf split_measure(9);
  split_measure << measure, 0.5f * measure[7];
  split_measure[7] *= 0.5f;
  const LocalPcaOptions options{.clusters = 3, .components = 1};
  const double whole = mean_error(LocalPca::fit(x, measure, options), x);
  const double halves = mean_error(LocalPca::fit(split, split_measure, options), split);
  EXPECT_NEAR(whole, halves, 1e-3 * whole);
  EXPECT_GT(whole, 0.0);
}

TEST(LocalPca, DimensionsOfWeightZeroHaveNoEffect) {
  Eigen::MatrixXf x = flats(10, 2, 1, 50, 0.0f);
  x.row(4) = 1000.0f * random_matrix(1, x.cols(), 8);
  Eigen::VectorXf measure = Eigen::VectorXf::Ones(10);
  measure[4] = 0.0f;
  const LocalPca pca = LocalPca::fit(x, measure, {.clusters = 2, .components = 1});
  EXPECT_LT(mean_error(pca, x), 1e-6);
  EXPECT_EQ(pca.decode(pca.encode(x.col(3)))[4], 0.0f);
}

TEST(LocalPca, FittedToASampleEncodesTheRest) {
  const Eigen::MatrixXf x = flats(20, 4, 2, 400, 0.02f);
  Eigen::MatrixXf sample(20, 200);
  for (int i = 0; i < 200; ++i) sample.col(i) = x.col(8 * i + 3);
  const LocalPca pca = LocalPca::fit(sample, {}, {.clusters = 4, .components = 2});
  EXPECT_LT(mean_error(pca, x), 1.5 * mean_error(pca, sample) + 1e-6);
}

TEST(LocalPca, DegenerateInput) {
  // Equal vectors, fewer vectors than clusters, more components than dimensions, one vector, zeros.
  const Eigen::MatrixXf equal = Eigen::VectorXf::LinSpaced(5, 1.0f, 2.0f) * Eigen::RowVectorXf::Ones(7);
  EXPECT_LT(mean_error(LocalPca::fit(equal, {}, {.clusters = 4, .components = 3}), equal), 1e-10);
  const Eigen::MatrixXf few = random_matrix(6, 3, 9);
  EXPECT_LT(mean_error(LocalPca::fit(few, {}, {.clusters = 8, .components = 2}), few), 1e-10);
  const Eigen::MatrixXf small = random_matrix(2, 50, 10);
  const LocalPca full = LocalPca::fit(small, {}, {.clusters = 2, .components = 5});
  EXPECT_LT(mean_error(full, small), 1e-8);
  EXPECT_EQ(full.encode(small.col(0)).weights.size(), 5);
  EXPECT_LT(mean_error(LocalPca::fit(few.leftCols(1), {}, {}), few.leftCols(1)), 1e-10);
  const Eigen::MatrixXf zeros = Eigen::MatrixXf::Zero(4, 9);
  EXPECT_EQ(mean_error(LocalPca::fit(zeros, {}, {}), zeros), 0.0);
}

/// Vectors near planes of a few clusters.
Eigen::MatrixXf clustered(int dimensions, int count, int clusters, int components, float noise) {
  std::mt19937 random(23);
  std::normal_distribution<float> normal;
  const auto draw = [&](int rows, int cols) {
    return Eigen::MatrixXf(Eigen::MatrixXf::NullaryExpr(rows, cols, [&] { return normal(random); }));
  };
  std::vector<Eigen::MatrixXf> means, bases;
  for (int k = 0; k < clusters; ++k)
    means.push_back(4.0f * draw(dimensions, 1)), bases.push_back(draw(dimensions, components));
  Eigen::MatrixXf x(dimensions, count);
  for (int i = 0; i < count; ++i) {
    const auto k = static_cast<std::size_t>(i % clusters);
    // One after the other: compilers differ in what they draw first.
    const Eigen::MatrixXf noises = draw(dimensions, 1), shares = draw(components, 1);
    x.col(i) = means[k] + bases[k] * shares + noise * noises;
  }
  return x;
}

TEST(LocalPcaOfAll, FindsWhatTheSampledFitFinds) {
  const Eigen::MatrixXf x = clustered(150, 1500, 5, 3, 0.05f);
  LocalPcaOptions options;
  options.clusters = 5;
  options.components = 3;
  const LocalPca slow = LocalPca::fit(x, {}, options);
  options.rounds = 14;
  const LocalPcaFit fast = fit_local_pca(x, {}, options);
  double error = 0.0;
  for (int i = 0; i < 1500; ++i) {
    const Eigen::VectorXf decoded = fast.pca.decode({fast.owner[static_cast<std::size_t>(i)], fast.weights.col(i)});
    const double own = static_cast<double>((x.col(i) - decoded).squaredNorm());
    EXPECT_NEAR(own, fast.errors[static_cast<std::size_t>(i)], 1e-3 * own + 1e-4);
    error += own / 1500.0;
  }
  EXPECT_LT(error, 1.05 * slow.history().back());
  EXPECT_LT(fast.lost, 0.01);
}

TEST(LocalPcaOfAll, IsTheSameForAnyNumberOfThreads) {
  const Eigen::MatrixXf x = clustered(90, 2000, 7, 2, 0.3f);
  LocalPcaOptions options;
  options.clusters = 9;
  options.components = 4;
  options.rounds = 8;
  const LocalPcaFit all = fit_local_pca(x, {}, options, 32);
  const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
  const LocalPcaFit alone = fit_local_pca(x, {}, options, 32);
  EXPECT_EQ(all.owner, alone.owner);
  EXPECT_EQ(all.weights, alone.weights);
  EXPECT_EQ(all.errors, alone.errors);
}

TEST(LocalPcaOfAll, OneClusterIsPlainPrincipalComponents) {
  const Eigen::MatrixXf x = clustered(120, 600, 3, 2, 0.2f);
  LocalPcaOptions options;
  options.clusters = 1;
  options.components = 6;
  options.rounds = 6;
  const LocalPcaFit fit = fit_local_pca(x, {}, options);
  const Eigen::MatrixXd centred = (x.colwise() - x.rowwise().mean()).cast<double>();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(centred * centred.transpose());
  const double rest = solver.eigenvalues().head(120 - 6).sum();
  double error = 0.0;
  for (const double e : fit.errors) error += e;
  EXPECT_NEAR(error, rest, 0.01 * rest);
  const Eigen::MatrixXf basis = fit.pca.components(0);
  for (int c = 0; c < 6; ++c) {
    Eigen::Index largest = 0;
    basis.col(c).cwiseAbs().maxCoeff(&largest);
    EXPECT_GT(basis(largest, c), 0.0f);
  }
}

TEST(LocalPcaOfAll, DegenerateInputIsNoTrouble) {
  LocalPcaOptions options;
  options.clusters = 128;
  options.components = 8;
  options.rounds = 6;
  const LocalPcaFit zero = fit_local_pca(Eigen::MatrixXf::Zero(100, 50), {}, options);
  EXPECT_EQ(zero.weights.cwiseAbs().maxCoeff(), 0.0f);
  const Eigen::MatrixXf few = clustered(100, 5, 5, 1, 0.0f);
  const LocalPcaFit fit = fit_local_pca(few, {}, options);
  for (const double e : fit.errors) EXPECT_LT(e, 1e-4);
  const LocalPcaFit same = fit_local_pca(few.col(0).replicate(1, 40), {}, options);
  for (const double e : same.errors) EXPECT_LT(e, 1e-4);
}

}  // namespace
}  // namespace maquette
