#include "render/prt/joint_transfer.h"

#include <algorithm>
#include <cmath>
#include <random>

#include "scenes/btf/half_floats.h"
#include "scenes/linear_algebra.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

using Eigen::Index;
constexpr Index kKept = 64;        ///< dimensions of the vertices' subspace
constexpr Index kMixedRows = 256;  ///< of all views together, at least
constexpr Index kLeastMixed = 8;   ///< of each view
constexpr Index kGramBlock = 256;  ///< columns that a thread takes at a time

template <typename Work>
void for_blocks(Index columns, const Work& work) {
  parallel_for(Index{0}, (columns + kGramBlock - 1) / kGramBlock,
               [&](Index b) { work(b * kGramBlock, std::min(kGramBlock, columns - b * kGramBlock)); });
}

/// The leading subspace of columns that are given block of rows by block of rows.
class RowMerger {
 public:
  /// `rows`: appended below those before.
  void add(const Eigen::MatrixXf& rows) {
    Eigen::MatrixXf all(kept_.rows() + rows.rows(), rows.cols());
    if (kept_.rows() > 0) all.topRows(kept_.rows()) = kept_;
    all.bottomRows(rows.rows()) = rows;
    if (all.rows() > 2 * kKept) all = reduced(all);
    kept_ = std::move(all);
  }
  Eigen::MatrixXf finish() { return kept_.rows() > kKept ? reduced(kept_) : kept_; }

 private:
  static Eigen::MatrixXf reduced(const Eigen::MatrixXf& all) {
    const Index blocks = (all.cols() + kGramBlock - 1) / kGramBlock;
    std::vector<Eigen::MatrixXd> parts(static_cast<std::size_t>(blocks));
    for_blocks(all.cols(), [&](Index first, Index size) {
      const Eigen::MatrixXd x = all.middleCols(first, size).cast<double>();
      parts[static_cast<std::size_t>(first / kGramBlock)] = times_transposed(x, x);
    });
    Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(all.rows(), all.rows());
    for (const Eigen::MatrixXd& part : parts) gram += part;
    const SymmetricEigen solver(gram);
    const Eigen::MatrixXf turn = solver.eigenvectors().rightCols(kKept).rowwise().reverse().cast<float>();
    Eigen::MatrixXf kept(kKept, all.cols());
    for_blocks(all.cols(), [&](Index first, Index size) {
      kept.middleCols(first, size) = transposed_times(turn, all.middleCols(first, size));
    });
    return kept;
  }
  Eigen::MatrixXf kept_;
};

Eigen::MatrixXf random_signs(Index rows, Index columns, std::uint32_t seed) {
  std::mt19937 random(seed);
  Eigen::MatrixXf signs(rows, columns);
  const float one = 1.0f / std::sqrt(static_cast<float>(rows));
  for (Index i = 0; i < signs.size(); ++i) signs.data()[i] = (random() & 1u) != 0 ? one : -one;
  return signs;
}

/// One factorisation under way.
class JointFactoriser {
 public:
  JointFactoriser(const std::function<Eigen::MatrixXf(std::size_t)>& transfer, std::size_t views,
                  const CubeDirections& directions, const JointTransferOptions& options)
      : transfer_(transfer), views_(views), directions_(directions), options_(options) {}

  std::vector<TransferMatrix> run() {
    find_weights();
    std::vector<TransferMatrix> made;
    for (std::size_t v = 0; v < views_ && !stopped(); ++v) made.push_back(view(v));
    if (stopped()) return {};
    for (TransferMatrix& matrix : made) matrix.owner = owner_;
    made[0].weights = std::move(weights_);
    return made;
  }

 private:
  bool stopped() const { return options_.stop && options_.stop(); }

  void find_weights() {
    RowMerger merger;
    const Index mixed =
        std::max<Index>(kLeastMixed, (kMixedRows + static_cast<Index>(views_) - 1) / static_cast<Index>(views_));
    for (std::size_t v = 0; v < views_ && !stopped(); ++v) {
      const Eigen::MatrixXf t = transfer_(v);
      channels_ = t.rows() / directions_.count();
      const Eigen::VectorXf roots = directions_.solid_angles().cast<float>().cwiseSqrt().replicate(channels_, 1);
      const Eigen::MatrixXf mix = random_signs(mixed, t.rows(), static_cast<std::uint32_t>(v + 1)) * roots.asDiagonal();
      Eigen::MatrixXf rows(mixed, t.cols());
      for_blocks(t.cols(), [&](Index first, Index size) {
        rows.middleCols(first, size) = times(mix, t.middleCols(first, size));
      });
      merger.add(rows);
    }
    if (stopped()) return;
    const Eigen::MatrixXf kept = merger.finish();
    LocalPcaOptions pca;
    pca.clusters = options_.clusters;
    pca.components = options_.components;
    pca.rounds = 10;
    pca.stop = options_.stop;
    const LocalPcaFit fit = fit_local_pca(kept, {}, pca);
    clusters_ = options_.clusters;
    const Index terms = 1 + options_.components;
    members_.resize(static_cast<std::size_t>(clusters_));
    for (std::size_t i = 0; i < fit.owner.size(); ++i) {
      owner_.push_back(static_cast<std::uint16_t>(fit.owner[i]));
      members_[static_cast<std::size_t>(fit.owner[i])].push_back(static_cast<Index>(i));
    }
    weights_.assign(fit.owner.size() * static_cast<std::size_t>(options_.components), 0);
    for (const std::vector<Index>& own : members_) {
      Eigen::MatrixXf design = Eigen::MatrixXf::Ones(static_cast<Index>(own.size()), terms);
      for (Index c = 1; c < terms && !own.empty(); ++c) {
        double squares = 0.0;
        for (const Index i : own) squares += std::pow(static_cast<double>(fit.weights(c - 1, i)), 2.0);
        const auto scale = static_cast<float>(std::sqrt(squares / static_cast<double>(own.size())));
        for (std::size_t n = 0; n < own.size(); ++n) {
          const std::uint16_t half = half_of_float(scale > 0.0f ? fit.weights(c - 1, own[n]) / scale : 0.0f);
          weights_[static_cast<std::size_t>(own[n] * options_.components + c - 1)] = half;
          design(static_cast<Index>(n), c) = float_of_half(half);
        }
      }
      solvers_.push_back(solver_of(design));
      designs_.push_back(std::move(design));
    }
  }

  /// [term][member]: least squares of what members have by their design; 0 for what the design lacks.
  static Eigen::MatrixXf solver_of(const Eigen::MatrixXf& design) {
    if (design.rows() == 0) return Eigen::MatrixXf(design.cols(), 0);
    const Eigen::MatrixXd wide = design.cast<double>();
    const SymmetricEigen solver(transposed_times(wide, wide));
    const Eigen::ArrayXd values = solver.eigenvalues().array();
    const Eigen::VectorXd inverse = (values > 1e-9 * values.maxCoeff()).select(values.max(1e-300).inverse(), 0.0);
    const Eigen::MatrixXd scaled = solver.eigenvectors() * inverse.asDiagonal();
    return times_transposed(times_transposed(scaled, solver.eigenvectors()), wide).cast<float>();
  }

  TransferMatrix view(std::size_t v) const {
    const Eigen::MatrixXf t = transfer_(v);
    const Eigen::VectorXf measure = directions_.solid_angles().cast<float>().replicate(channels_, 1);
    const Index dimensions = directions_.count(), terms = 1 + options_.components;
    TransferMatrix matrix;
    matrix.clusters = clusters_;
    matrix.components = options_.components;
    matrix.channels = static_cast<int>(channels_);
    const std::size_t rows = matrix.rows();
    matrix.q.assign(rows * static_cast<std::size_t>(t.rows()), 0);
    matrix.squares.assign(static_cast<std::size_t>(t.cols()), 0.0f);
    std::vector<double> energy(static_cast<std::size_t>(clusters_), 0.0);
    parallel_for(std::size_t{0}, members_.size(), [&](std::size_t k) {
      const std::vector<Index>& own = members_[k];
      if (own.empty()) return;
      Eigen::MatrixXf q = Eigen::MatrixXf::Zero(t.rows(), terms);
      for (std::size_t n = 0; n < own.size(); ++n)
        q.noalias() += t.col(own[n]) * solvers_[k].col(static_cast<Index>(n)).transpose();
      for (std::size_t n = 0; n < own.size(); ++n) {
        const Eigen::VectorXf left = t.col(own[n]) - q * designs_[k].row(static_cast<Index>(n)).transpose();
        matrix.squares[static_cast<std::size_t>(own[n])] = measure.dot(left.cwiseAbs2());
        energy[k] += static_cast<double>(measure.dot(t.col(own[n]).cwiseAbs2()));
      }
      q = measure.asDiagonal() * q;
      for (Index c = 0; c < terms; ++c) {
        for (Index n = 0; n < channels_; ++n)
          haar_transform_faces(directions_.side(), q.col(c).data() + n * dimensions);
        const std::size_t row = k * static_cast<std::size_t>(terms) + static_cast<std::size_t>(c);
        for (Index j = 0; j < q.rows(); ++j)
          matrix.q[static_cast<std::size_t>(j) * rows + row] = half_of_float(q(j, c));
      }
    });
    double squared = 0.0, all = 0.0;
    for (const double e : energy) all += e;
    for (const float s : matrix.squares) squared += static_cast<double>(s);
    matrix.energy = t.cols() > 0 ? all / static_cast<double>(t.cols()) : 0.0;
    matrix.error = all > 0.0 ? std::sqrt(squared / all) : 0.0;
    return matrix;
  }

  const std::function<Eigen::MatrixXf(std::size_t)>& transfer_;
  const std::size_t views_;
  const CubeDirections& directions_;
  const JointTransferOptions& options_;
  Index channels_ = 1;
  int clusters_ = 0;
  std::vector<std::uint16_t> owner_, weights_;
  std::vector<std::vector<Index>> members_;         ///< [cluster]
  std::vector<Eigen::MatrixXf> designs_, solvers_;  ///< [cluster]
};

}  // namespace

std::vector<TransferMatrix> factorise_joint_transfer(const std::function<Eigen::MatrixXf(std::size_t view)>& transfer,
                                                     std::size_t views, const CubeDirections& directions,
                                                     const JointTransferOptions& options) {
  return JointFactoriser(transfer, views, directions, options).run();
}

Eigen::MatrixXf decode_joint_transfer(const std::vector<TransferMatrix>& joint, std::size_t view,
                                      const CubeDirections& directions) {
  TransferMatrix one = joint[view];
  one.weights = joint[0].weights;
  return decode_transfer(one, directions);
}

}  // namespace maquette
