#include "render/math/local_pca.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <limits>
#include <random>

#include "scenes/linear_algebra.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

/// Up to this many rows or columns the eigenvectors are computed exactly.
constexpr Eigen::Index kExactSide = 1024;
constexpr Eigen::Index kOversampling = 8;
constexpr int kPowerRounds = 4;
constexpr int kLloydRounds = 4;

/// Leading left singular vectors of `x`, as orthonormal columns.
Eigen::MatrixXf leading_vectors(const Eigen::MatrixXf& x, Eigen::Index count, std::uint32_t seed) {
  const Eigen::Index most = std::min(x.rows(), x.cols());
  count = std::min(count, most);
  if (count <= 0) return Eigen::MatrixXf(x.rows(), 0);
  Eigen::MatrixXf range = x;
  if (most > kExactSide) {
    // Source: Halko, Martinsson and Tropp 2011, "Finding Structure with Randomness", Alg. 4.4.
    std::mt19937 random(seed);
    std::normal_distribution<float> normal;
    Eigen::MatrixXf q(x.cols(), std::min(most, count + kOversampling));
    for (Eigen::Index i = 0; i < q.size(); ++i) q.data()[i] = normal(random);
    Eigen::MatrixXf left = orthonormal_columns(times(x, q));
    for (int round = 0; round < kPowerRounds; ++round)
      left = orthonormal_columns(times(x, orthonormal_columns(transposed_times(x, left))));
    const Eigen::MatrixXf small = transposed_times(left, x);
    const SymmetricEigen solver(times_transposed(small, small).cast<double>());
    return times(left, solver.eigenvectors().rightCols(count).rowwise().reverse().cast<float>());
  }
  // The smaller of the two Gram matrices, in double, because the eigenvalues are squares.
  const Eigen::MatrixXd wide = x.cast<double>();
  if (x.rows() <= x.cols()) {
    const SymmetricEigen solver(times_transposed(wide, wide));
    return solver.eigenvectors().rightCols(count).rowwise().reverse().cast<float>();
  }
  const SymmetricEigen solver(transposed_times(wide, wide));
  Eigen::MatrixXd vectors = times(wide, solver.eigenvectors().rightCols(count).rowwise().reverse());
  const double largest = vectors.col(0).norm();
  Eigen::Index kept = 0;
  for (Eigen::Index c = 0; c < count; ++c) {
    const double length = vectors.col(c).norm();
    if (!(length > 1e-7 * largest) || !(length > 0.0)) break;
    vectors.col(c) /= length;
    ++kept;
  }
  return vectors.leftCols(kept).cast<float>();
}

double squared_error(const Eigen::VectorXf& centred, const Eigen::MatrixXf& basis) {
  const double all = static_cast<double>(centred.squaredNorm());
  const double kept = basis.cols() > 0 ? static_cast<double>((basis.transpose() * centred).squaredNorm()) : 0.0;
  return std::max(all - kept, 0.0);
}

/// Source: Arthur and Vassilvitskii 2007, "k-means++", Sec. 2.2.
std::vector<int> seed_clusters(const Eigen::MatrixXf& scaled, int count, std::mt19937* random) {
  const auto samples = static_cast<int>(scaled.cols());
  std::vector<int> seeds{static_cast<int>((*random)() % static_cast<unsigned>(samples))};
  Eigen::VectorXd nearest = Eigen::VectorXd::Constant(samples, std::numeric_limits<double>::infinity());
  while (static_cast<int>(seeds.size()) < count) {
    nearest = nearest.cwiseMin(
        (scaled.colwise() - scaled.col(seeds.back())).colwise().squaredNorm().transpose().cast<double>());
    const double total = nearest.sum();
    if (!(total > 0.0)) break;  // fewer distinct vectors than clusters
    double pick = std::uniform_real_distribution<double>(0.0, total)(*random);
    int chosen = 0;
    while (chosen < samples - 1 && (pick -= nearest[chosen]) > 0.0) ++chosen;
    seeds.push_back(chosen);
  }
  return seeds;
}

}  // namespace

LocalPca::Cluster LocalPca::fit_cluster(const Eigen::MatrixXf& scaled, const std::vector<int>& members, int components,
                                        std::uint32_t seed) {
  Eigen::MatrixXf x(scaled.rows(), static_cast<Eigen::Index>(members.size()));
  for (std::size_t i = 0; i < members.size(); ++i) x.col(static_cast<Eigen::Index>(i)) = scaled.col(members[i]);
  Cluster cluster;
  cluster.mean = x.cast<double>().rowwise().mean().cast<float>();
  x.colwise() -= cluster.mean;
  cluster.basis = components > 0 ? leading_vectors(x, components, seed) : Eigen::MatrixXf(scaled.rows(), 0);
  return cluster;
}

LocalPca LocalPca::fit(const Eigen::MatrixXf& samples, const Eigen::VectorXf& measure, const LocalPcaOptions& options) {
  assert(samples.cols() > 0 && (measure.size() == 0 || measure.size() == samples.rows()));
  LocalPca pca;
  pca.components_ = options.components;
  pca.roots_ =
      measure.size() > 0 ? Eigen::VectorXf(measure.cwiseMax(0.0f).cwiseSqrt()) : Eigen::VectorXf::Ones(samples.rows());
  const Eigen::MatrixXf scaled = pca.roots_.asDiagonal() * samples;
  const auto count = static_cast<std::size_t>(samples.cols());
  std::mt19937 random(options.seed);
  const std::vector<int> seeds =
      seed_clusters(scaled, std::clamp(options.clusters, 1, static_cast<int>(samples.cols())), &random);
  for (int s : seeds) pca.clusters_.push_back({scaled.col(s), Eigen::MatrixXf(scaled.rows(), 0)});
  std::vector<int> owner(count, 0);
  std::vector<double> errors(count, 0.0);
  for (int round = 0; round < kLloydRounds + options.rounds; ++round) {
    if (options.stop && options.stop()) break;
    parallel_for(std::size_t{0}, count, [&](std::size_t i) {
      errors[i] = std::numeric_limits<double>::infinity();
      for (std::size_t k = 0; k < pca.clusters_.size(); ++k) {
        const Cluster& cluster = pca.clusters_[k];
        const double e = squared_error(scaled.col(static_cast<Eigen::Index>(i)) - cluster.mean, cluster.basis);
        if (e < errors[i]) errors[i] = e, owner[i] = static_cast<int>(k);
      }
    });
    double sum = 0.0;
    for (double e : errors) sum += e;
    const double mean = sum / static_cast<double>(count);
    if (round > kLloydRounds) {
      const bool settled = !pca.history_.empty() && mean > (1.0 - options.least_gain) * pca.history_.back();
      pca.history_.push_back(mean);
      if (settled || mean == 0.0) break;
    }
    std::vector<std::vector<int>> members(pca.clusters_.size());
    for (std::size_t i = 0; i < count; ++i) members[static_cast<std::size_t>(owner[i])].push_back(static_cast<int>(i));
    for (auto& m : members) {
      if (!m.empty()) continue;
      // An empty cluster restarts at the vector with the largest error.
      const auto worst = static_cast<std::size_t>(std::max_element(errors.begin(), errors.end()) - errors.begin());
      m.push_back(static_cast<int>(worst));
      errors[worst] = 0.0;
    }
    const int components = round < kLloydRounds ? 0 : options.components;
    parallel_for(std::size_t{0}, members.size(), [&](std::size_t k) {
      pca.clusters_[k] = fit_cluster(scaled, members[k], components, options.seed + static_cast<std::uint32_t>(k));
    });
  }
  pca.gather();
  return pca;
}

LocalPca LocalPca::restore(const Eigen::VectorXf& measure, const Eigen::MatrixXf& means,
                           const Eigen::MatrixXf& components) {
  LocalPca pca;
  const Eigen::Index count = means.cols() > 0 ? components.cols() / means.cols() : 0;
  pca.components_ = static_cast<int>(count);
  pca.roots_ = measure.cwiseMax(0.0f).cwiseSqrt();
  for (Eigen::Index k = 0; k < means.cols(); ++k) {
    Cluster cluster{pca.roots_.cwiseProduct(means.col(k)),
                    pca.roots_.asDiagonal() * components.middleCols(k * count, count)};
    // Columns that the fit did not need are filled with 0.
    Eigen::Index used = count;
    while (used > 0 && cluster.basis.col(used - 1).squaredNorm() < 0.5f) --used;
    cluster.basis.conservativeResize(Eigen::NoChange, used);
    pca.clusters_.push_back(std::move(cluster));
  }
  pca.gather();
  return pca;
}

void LocalPca::gather() {
  Eigen::Index columns = 0;
  for (const Cluster& c : clusters_) columns += 1 + c.basis.cols();
  gathered_.resize(roots_.size(), columns);
  Eigen::Index at = 0;
  for (const Cluster& c : clusters_) {
    gathered_.col(at) = c.mean;
    gathered_.middleCols(at + 1, c.basis.cols()) = c.basis;
    at += 1 + c.basis.cols();
  }
}

LocalPcaCode LocalPca::encode(const Eigen::VectorXf& x) const { return encode_all(x).front(); }

std::vector<LocalPcaCode> LocalPca::encode_all(const Eigen::MatrixXf& x) const {
  const Eigen::MatrixXf scaled = roots_.asDiagonal() * x;
  const Eigen::MatrixXf products = transposed_times(gathered_, scaled);
  std::vector<LocalPcaCode> codes(static_cast<std::size_t>(x.cols()));
  std::vector<double> best(codes.size(), std::numeric_limits<double>::infinity());
  Eigen::Index at = 0;
  for (std::size_t k = 0; k < clusters_.size(); ++k) {
    const Cluster& cluster = clusters_[k];
    const Eigen::Index count = cluster.basis.cols();
    const Eigen::VectorXf of_mean = cluster.basis.transpose() * cluster.mean;
    const auto mean2 = static_cast<double>(cluster.mean.squaredNorm());
    for (std::size_t i = 0; i < codes.size(); ++i) {
      const auto column = products.col(static_cast<Eigen::Index>(i)).segment(at, 1 + count);
      const Eigen::VectorXf weights = column.tail(count) - of_mean;
      // |x - m|^2 minus what the components explain; |x|^2 is the same for all clusters.
      const double e = mean2 - 2.0 * static_cast<double>(column[0]) - static_cast<double>(weights.squaredNorm());
      if (e >= best[i]) continue;
      best[i] = e;
      codes[i].cluster = static_cast<int>(k);
      codes[i].weights = Eigen::VectorXf::Zero(components_);
      codes[i].weights.head(count) = weights;
    }
    at += 1 + count;
  }
  return codes;
}

Eigen::VectorXf LocalPca::unscale(const Eigen::VectorXf& scaled) const {
  return (roots_.array() > 0.0f).select(scaled.array() / roots_.array().max(1e-30f), 0.0f);
}

Eigen::VectorXf LocalPca::decode(const LocalPcaCode& code) const {
  const Cluster& cluster = clusters_[static_cast<std::size_t>(code.cluster)];
  return unscale(cluster.mean + cluster.basis * code.weights.head(cluster.basis.cols()));
}

double LocalPca::error(const Eigen::VectorXf& x) const {
  const Eigen::VectorXf difference = roots_.cwiseProduct(x - decode(encode(x)));
  return static_cast<double>(difference.squaredNorm());
}

Eigen::VectorXf LocalPca::mean(int cluster) const { return unscale(clusters_[static_cast<std::size_t>(cluster)].mean); }

Eigen::MatrixXf LocalPca::components(int cluster) const {
  const Eigen::MatrixXf& basis = clusters_[static_cast<std::size_t>(cluster)].basis;
  Eigen::MatrixXf result = Eigen::MatrixXf::Zero(basis.rows(), components_);
  for (Eigen::Index c = 0; c < basis.cols(); ++c) result.col(c) = unscale(basis.col(c));
  return result;
}

}  // namespace maquette
