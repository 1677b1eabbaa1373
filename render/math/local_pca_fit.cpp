#include "render/math/local_pca_fit.h"

#include <algorithm>
#include <cassert>
#include <limits>
#include <random>

#include "render/math/cluster_members.h"
#include "scenes/linear_algebra.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

using Eigen::Index;
/// Vectors that the sketch's subspace is computed from, at most.
constexpr Index kSketchSamples = 16384;
/// Columns that a thread takes at a time; sums are over whole blocks in their order.
constexpr Index kBlock = 512;
constexpr Index kSeedSamples = 8192;
constexpr int kFullIterations = 2;  ///< of the subspace, in full dimension
/// From so many dimensions on the sketch's subspace is sought at random: the eigenvectors of the whole matrix would
/// cost more than all the rest.
constexpr Index kRandomDimensions = 1025;
constexpr Index kRandomSamples = 4096, kFitOversampling = 16;
constexpr int kFitPowerRounds = 2;

Index block_count(Index columns) { return (columns + kBlock - 1) / kBlock; }

template <typename Work>
void for_blocks(Index columns, const Work& work) {
  parallel_for(Index{0}, block_count(columns),
               [&](Index b) { work(b * kBlock, std::min(kBlock, columns - b * kBlock)); });
}

void orthonormalize(Eigen::MatrixXf* m) {
  if (m->cols() == 0) return;
  *m = orthonormal_columns(*m);
}

void fix_signs(Eigen::MatrixXf* basis) {
  for (Index c = 0; c < basis->cols(); ++c) {
    Index largest = 0;
    basis->col(c).cwiseAbs().maxCoeff(&largest);
    if ((*basis)(largest, c) < 0.0f) basis->col(c) = -basis->col(c);
  }
}

/// Orthonormal eigenvectors of a symmetric matrix with the largest eigenvalues, those of zero left out.
Eigen::MatrixXf leading(const Eigen::MatrixXd& matrix, Index count) {
  if (matrix.rows() == 0) return Eigen::MatrixXf(0, 0);
  const SymmetricEigen solver(matrix);
  const Eigen::VectorXd& values = solver.eigenvalues();
  Index kept = 0;
  while (kept < std::min(count, values.size()) &&
         values[values.size() - 1 - kept] > 1e-12 * std::max(values[values.size() - 1], 1e-280))
    ++kept;
  return solver.eigenvectors().rightCols(kept).rowwise().reverse().cast<float>();
}

/// Trace of B^T G B.
double trace_within(const Eigen::MatrixXd& gram, const Eigen::MatrixXd& basis) {
  return times(transposed_times(basis, gram), basis).trace();
}

struct Subspace {
  Eigen::MatrixXf basis;  ///< orthonormal columns
  double lost = 0.0;      ///< share of the energy that it does not hold
};

/// Leading subspace of the columns of `x`. Source: Halko, Martinsson and Tropp 2011, "Finding Structure with
/// Randomness", Alg. 4.4 and 5.1.
Subspace random_subspace(const Eigen::MatrixXf& x, Index count, std::uint32_t seed) {
  std::mt19937 random(seed);
  Eigen::MatrixXf start(x.cols(), std::min({count + kFitOversampling, x.rows(), x.cols()}));
  for (Index i = 0; i < start.size(); ++i) start.data()[i] = static_cast<float>(random()) / 2147483648.0f - 1.0f;
  Eigen::MatrixXf range = times(x, start);
  orthonormalize(&range);
  for (int round = 0; round < kFitPowerRounds; ++round) {
    range = times(x, transposed_times(x, range));
    orthonormalize(&range);
  }
  const Eigen::MatrixXf small = transposed_times(range, x);
  Subspace space;
  space.basis = times(range, leading(times_transposed(small, small).cast<double>(), count));
  const double all = x.cast<double>().squaredNorm(),
               kept = transposed_times(space.basis, x).cast<double>().squaredNorm();
  space.lost = all > 0.0 ? std::max(1.0 - kept / all, 0.0) : 0.0;
  return space;
}

/// One fit under way.
class LocalPcaFitter {
 public:
  LocalPcaFitter(const Eigen::MatrixXf& samples, const Eigen::VectorXf& measure, const LocalPcaOptions& options,
                 int sketch)
      : options_(options), sketch_(sketch) {
    measure_ = measure.size() > 0 ? Eigen::VectorXf(measure.cwiseMax(0.0f)) : Eigen::VectorXf::Ones(samples.rows());
    scaled_ = measure_.cwiseSqrt().asDiagonal() * samples;
    fit_.owner.assign(static_cast<std::size_t>(samples.cols()), 0);
    errors_.assign(fit_.owner.size(), 0.0f);
  }

  LocalPcaFit fit() {
    make_sketch();
    seed();
    const int rounds = std::max(options_.rounds, 1);
    for (int round = 0; round < rounds && !(options_.stop && options_.stop()); ++round) {
      assign();
      // Components are raised one by one: started with all of them, clusters settle in worse places.
      const int rising = std::max(rounds - 4, 1);
      update(std::min(options_.components, options_.components * (round + 1) / rising + 1));
    }
    assign();
    finish();
    return std::move(fit_);
  }

  LocalPcaSketch sketch() {
    make_sketch();
    const double all = (scaled_.cast<double>().colwise() - mean_).squaredNorm();
    return {std::move(small_), fit_.lost * all / static_cast<double>(scaled_.cols())};
  }

 private:
  struct Cluster {
    Eigen::VectorXf mean;
    Eigen::MatrixXf basis;
  };

  void make_sketch() {
    mean_ = Eigen::VectorXd::Zero(scaled_.rows());
    for (Index i = 0; i < scaled_.cols(); i += kBlock)
      mean_ += scaled_.middleCols(i, std::min(kBlock, scaled_.cols() - i)).cast<double>().rowwise().sum();
    mean_ /= static_cast<double>(scaled_.cols());
    const Eigen::VectorXf mean = mean_.cast<float>();
    if (scaled_.rows() <= sketch_) {
      lift_ = Eigen::MatrixXf::Identity(scaled_.rows(), scaled_.rows());
    } else if (scaled_.rows() >= kRandomDimensions) {
      const Index step = std::max<Index>(1, (scaled_.cols() + kRandomSamples - 1) / kRandomSamples);
      Eigen::MatrixXf x(scaled_.rows(), (scaled_.cols() + step - 1) / step);
      for (Index i = 0; i < x.cols(); ++i) x.col(i) = scaled_.col(i * step) - mean;
      Subspace space = random_subspace(x, sketch_, options_.seed);
      lift_ = std::move(space.basis);
      fit_.lost = space.lost;
      if (lift_.cols() == 0) lift_ = Eigen::MatrixXf::Identity(scaled_.rows(), 1);
    } else {
      const Index step = std::max<Index>(1, (scaled_.cols() + kSketchSamples - 1) / kSketchSamples);
      const Index count = (scaled_.cols() + step - 1) / step;
      std::vector<Eigen::MatrixXf> parts(static_cast<std::size_t>(block_count(count)));
      for_blocks(count, [&](Index first, Index size) {
        Eigen::MatrixXf x(scaled_.rows(), size);
        for (Index i = 0; i < size; ++i) x.col(i) = scaled_.col((first + i) * step) - mean;
        parts[static_cast<std::size_t>(first / kBlock)] = times_transposed(x, x);
      });
      Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(scaled_.rows(), scaled_.rows());
      for (const Eigen::MatrixXf& part : parts) gram += part.cast<double>();
      lift_ = leading(gram, sketch_);
      const double all = gram.trace(), kept = trace_within(gram, lift_.cast<double>());
      fit_.lost = all > 0.0 ? std::max(1.0 - kept / all, 0.0) : 0.0;
      if (lift_.cols() == 0) lift_ = Eigen::MatrixXf::Identity(scaled_.rows(), 1);
    }
    small_.resize(lift_.cols(), scaled_.cols());
    for_blocks(scaled_.cols(), [&](Index first, Index size) {
      small_.middleCols(first, size) = transposed_times(lift_, scaled_.middleCols(first, size).colwise() - mean);
    });
  }

  /// Source: Arthur and Vassilvitskii 2007, "k-means++", Sec. 2.2.
  void seed() {
    std::mt19937 random(options_.seed);
    const Index step = std::max<Index>(1, small_.cols() / kSeedSamples), count = (small_.cols() + step - 1) / step;
    const int wanted = std::clamp(options_.clusters, 1, static_cast<int>(small_.cols()));
    Eigen::VectorXf nearest = Eigen::VectorXf::Constant(count, std::numeric_limits<float>::max());
    Index pick = static_cast<Index>(random() % static_cast<unsigned>(count)) * step;
    while (true) {
      clusters_.push_back({small_.col(pick), Eigen::MatrixXf(small_.rows(), 0)});
      if (static_cast<int>(clusters_.size()) == wanted) return;
      double total = 0.0;
      for (Index i = 0; i < count; ++i) {
        nearest[i] = std::min(nearest[i], (small_.col(i * step) - clusters_.back().mean).squaredNorm());
        total += static_cast<double>(nearest[i]);
      }
      if (!(total > 0.0)) return;  // fewer distinct vectors than clusters
      double at = static_cast<double>(random()) / 4294967296.0 * total;
      Index chosen = 0;
      while (chosen + 1 < count && (at -= static_cast<double>(nearest[chosen])) > 0.0) ++chosen;
      pick = chosen * step;
    }
  }

  /// The cluster that reconstructs each vector best, in the sketch.
  void assign() {
    Index columns = 0;
    for (const Cluster& c : clusters_) columns += 1 + c.basis.cols();
    Eigen::MatrixXf gathered(small_.rows(), columns);
    std::vector<Eigen::VectorXf> of_mean;
    std::vector<float> mean2;
    Index at = 0;
    for (const Cluster& c : clusters_) {
      gathered.col(at) = c.mean;
      gathered.middleCols(at + 1, c.basis.cols()) = c.basis;
      at += 1 + c.basis.cols();
      of_mean.push_back(c.basis.transpose() * c.mean);
      mean2.push_back(c.mean.squaredNorm());
    }
    for_blocks(small_.cols(), [&](Index first, Index size) {
      const Eigen::MatrixXf products = transposed_times(gathered, small_.middleCols(first, size));
      for (Index i = 0; i < size; ++i) {
        const float own = small_.col(first + i).squaredNorm();
        float best = std::numeric_limits<float>::max();
        int owner = 0;
        const float* p = products.col(i).data();
        for (std::size_t k = 0; k < clusters_.size(); ++k) {
          const Index count = clusters_[k].basis.cols();
          float error = own + mean2[k] - 2.0f * *p++;
          for (Index c = 0; c < count; ++c, ++p) {
            const float w = *p - of_mean[k][c];
            error -= w * w;
          }
          if (error < best) best = error, owner = static_cast<int>(k);
        }
        fit_.owner[static_cast<std::size_t>(first + i)] = owner;
        errors_[static_cast<std::size_t>(first + i)] = std::max(best, 0.0f);
      }
    });
  }

  void update(int components) {
    const auto members = members_of_clusters(fit_.owner, clusters_.size(), &errors_);
    parallel_for(std::size_t{0}, clusters_.size(), [&](std::size_t k) {
      Eigen::VectorXd mean = Eigen::VectorXd::Zero(small_.rows());
      for (const Index i : members[k]) mean += small_.col(i).cast<double>();
      mean /= static_cast<double>(members[k].size());
      Cluster& cluster = clusters_[k];
      cluster.mean = mean.cast<float>();
      cluster.basis.resize(small_.rows(), 0);
      if (components == 0) return;
      Eigen::MatrixXf x(small_.rows(), static_cast<Index>(members[k].size()));
      for (Index i = 0; i < x.cols(); ++i)
        x.col(i) = small_.col(members[k][static_cast<std::size_t>(i)]) - cluster.mean;
      const Eigen::MatrixXd wide = x.cast<double>();
      cluster.basis = leading(times_transposed(wide, wide), components);
    });
  }

  /// Means and components in full dimension, and the codes.
  void finish() {
    const Index n = scaled_.cols();
    fit_.weights = Eigen::MatrixXf::Zero(options_.components, n);
    fit_.errors.assign(static_cast<std::size_t>(n), 0.0);
    const auto members = members_of_clusters(fit_.owner, clusters_.size(), &errors_);
    const auto count = static_cast<Index>(clusters_.size()), dimensions = scaled_.rows();
    Eigen::MatrixXf means(dimensions, count), bases = Eigen::MatrixXf::Zero(dimensions, count * options_.components);
    parallel_for(Index{0}, count, [&](Index k) {
      const auto& own = members[static_cast<std::size_t>(k)];
      Eigen::MatrixXf x(dimensions, static_cast<Index>(own.size()));
      Eigen::VectorXd mean = Eigen::VectorXd::Zero(dimensions);
      for (const Index i : own) mean += scaled_.col(i).cast<double>();
      means.col(k) = (mean / static_cast<double>(own.size())).cast<float>();
      for (Index i = 0; i < x.cols(); ++i) x.col(i) = scaled_.col(own[static_cast<std::size_t>(i)]) - means.col(k);
      const Eigen::MatrixXf basis = full_basis(x, clusters_[static_cast<std::size_t>(k)].basis);
      bases.middleCols(k * options_.components, basis.cols()) = basis;
      const Eigen::MatrixXf w = transposed_times(basis, x);
      x -= times(basis, w);
      for (Index i = 0; i < x.cols(); ++i) {
        const Index sample = own[static_cast<std::size_t>(i)];
        if (fit_.owner[static_cast<std::size_t>(sample)] != static_cast<int>(k)) continue;  // of an empty cluster
        fit_.weights.col(sample).head(w.rows()) = w.col(i);
        fit_.errors[static_cast<std::size_t>(sample)] = static_cast<double>(x.col(i).squaredNorm());
      }
    });
    // A dimension of weight 0 is reconstructed as 0.
    const Eigen::VectorXf inverse = (measure_.array() > 0.0f).select(measure_.array().max(1e-30f).rsqrt(), 0.0f);
    fit_.pca = LocalPca::restore(measure_, inverse.asDiagonal() * means, inverse.asDiagonal() * bases);
  }

  /// Subspace iteration from what the sketch says, then the components in the order of their energy.
  Eigen::MatrixXf full_basis(const Eigen::MatrixXf& x, const Eigen::MatrixXf& small) const {
    if (small.cols() == 0 || x.cols() < 2) return Eigen::MatrixXf(x.rows(), 0);
    Eigen::MatrixXf basis = times(lift_, small);
    orthonormalize(&basis);
    for (int i = 0; i < kFullIterations; ++i) {
      basis = times(x, transposed_times(x, basis));
      orthonormalize(&basis);
    }
    const Eigen::MatrixXf w = transposed_times(basis, x);
    basis = times(basis, leading(times_transposed(w, w).cast<double>(), basis.cols()));
    fix_signs(&basis);
    return basis;
  }

  const LocalPcaOptions& options_;
  const int sketch_;
  LocalPcaFit fit_;
  Eigen::VectorXf measure_;
  Eigen::MatrixXf scaled_;  ///< [dimension][sample] by the roots of the measure
  Eigen::VectorXd mean_;
  Eigen::MatrixXf lift_;   ///< [dimension][sketch] orthonormal
  Eigen::MatrixXf small_;  ///< [sketch][sample]
  std::vector<Cluster> clusters_;
  std::vector<float> errors_;
};

}  // namespace

LocalPcaFit fit_local_pca(const Eigen::MatrixXf& samples, const Eigen::VectorXf& measure,
                          const LocalPcaOptions& options, int sketch) {
  assert(samples.cols() > 0 && (measure.size() == 0 || measure.size() == samples.rows()));
  return LocalPcaFitter(samples, measure, options, sketch).fit();
}

LocalPcaSketch sketch_for_local_pca(const Eigen::MatrixXf& samples, const Eigen::VectorXf& measure,
                                    Eigen::Index most_samples, int sketch) {
  const Index count = std::min(samples.cols(), most_samples);
  Eigen::MatrixXf some(samples.rows(), count);
  for (Index i = 0; i < count; ++i) some.col(i) = samples.col(i * samples.cols() / count);
  return LocalPcaFitter(some, measure, {}, sketch).sketch();
}

}  // namespace maquette
