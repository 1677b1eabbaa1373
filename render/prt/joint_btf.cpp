#include "render/prt/joint_btf.h"

#include <algorithm>
#include <limits>
#include <random>

#include "render/math/cluster_members.h"
#include "scenes/btf/half_floats.h"
#include "scenes/linear_algebra.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

using Eigen::Index;
constexpr Index kChannels = 3;
constexpr Index kSampledTexels = 4096;  ///< that clusters are fitted to
constexpr Index kSketch = 48;           ///< dimensions in which texels are assigned
constexpr int kRounds = 12;
constexpr Index kBlock = 256;  ///< texels that a thread takes at a time

/// Eigenvectors of a symmetric matrix with the largest values; columns of what is zero are zero.
Eigen::MatrixXf leading(const Eigen::MatrixXd& matrix, Index count) {
  const SymmetricEigen solver(matrix);
  const Eigen::VectorXd& values = solver.eigenvalues();
  Eigen::MatrixXf basis = Eigen::MatrixXf::Zero(matrix.rows(), count);
  for (Index k = 0; k < std::min(count, values.size()); ++k) {
    const Index at = values.size() - 1 - k;
    if (values[at] > 1e-12 * std::max(values[values.size() - 1], 1e-280))
      basis.col(k) = solver.eigenvectors().col(at).cast<float>();
  }
  return basis;
}

/// Coordinates in which distances of texels are those of their rho over all views and lights by cosine.
class TexelSpace {
 public:
  explicit TexelSpace(const Btf& btf) : btf_(btf), terms_(1 + btf.components) {
    const DirectionMesh* known = nullptr;
    std::vector<double> shares;
    for (const BtfView& view : btf.views) {
      if (known != view.lights.get()) shares = view.lights->quadrature().projected;
      known = view.lights.get();
      Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(terms_, terms_);
      for (std::size_t l = 0; l < shares.size(); ++l) {
        Eigen::VectorXd f = Eigen::VectorXd::Ones(terms_);
        for (Index c = 1; c < terms_; ++c)
          f[c] = static_cast<double>(
              view.light_weights[l * static_cast<std::size_t>(btf.components) + static_cast<std::size_t>(c - 1)]);
        gram += shares[l] * f * f.transpose();
      }
      const SymmetricEigen solver(gram);
      const Eigen::VectorXd roots = solver.eigenvalues().cwiseMax(0.0).cwiseSqrt();
      to_.push_back((roots.asDiagonal() * solver.eigenvectors().transpose()).cast<float>());
      const Eigen::VectorXd inverse =
          (roots.array() > 1e-6 * roots.maxCoeff()).select(roots.array().max(1e-300).inverse(), 0.0);
      from_.push_back((solver.eigenvectors() * inverse.asDiagonal()).cast<float>());
    }
  }
  Index dimensions() const { return terms_ * static_cast<Index>(btf_.views.size()); }
  /// Three columns, of the colours of a texel that begins at `offset` of each view's factors.
  void read(std::size_t offset, float* columns) const {
    Eigen::MatrixXf factors(terms_, kChannels);
    for (std::size_t v = 0; v < btf_.views.size(); ++v) {
      const std::uint16_t* halves = btf_.views[v].factors.data() + offset;
      for (Index c = 0; c < terms_; ++c)
        for (Index k = 0; k < kChannels; ++k) factors(c, k) = float_of_half(halves[c * kChannels + k]);
      const Eigen::MatrixXf y = times(to_[v], factors);
      for (Index k = 0; k < kChannels; ++k)
        std::copy_n(y.data() + k * terms_, terms_, columns + k * dimensions() + static_cast<Index>(v) * terms_);
    }
  }
  /// A direction of the space as a function of the lights of a view.
  std::vector<float> function(const Eigen::VectorXf& direction, std::size_t view) const {
    const Eigen::VectorXf f = from_[view] * direction.segment(static_cast<Index>(view) * terms_, terms_);
    const BtfView& of = btf_.views[view];
    std::vector<float> values(of.lights->size(), f[0]);
    for (std::size_t l = 0; l < values.size(); ++l)
      for (Index c = 1; c < terms_; ++c)
        values[l] +=
            f[c] * of.light_weights[l * static_cast<std::size_t>(btf_.components) + static_cast<std::size_t>(c - 1)];
    return values;
  }

 private:
  const Btf& btf_;
  Index terms_;
  std::vector<Eigen::MatrixXf> to_, from_;
};

/// Clusters of linear subspaces; the three colours of a texel belong to one.
class SubspaceClusters {
 public:
  SubspaceClusters(const Eigen::MatrixXf& samples, int clusters, Index terms) : samples_(samples), terms_(terms) {
    const Index texels = samples.cols() / kChannels;
    const Eigen::MatrixXd wide = samples.cast<double>();
    const Eigen::MatrixXf lift = leading(times_transposed(wide, wide), std::min(kSketch, samples.rows()));
    small_ = transposed_times(lift, samples);
    owner_.assign(static_cast<std::size_t>(texels), 0);
    residual_.assign(owner_.size(), 0.0f);
    seed(std::min<Index>(clusters, texels));
    for (int round = 0; round < kRounds; ++round) {
      assign();
      update(std::min<Index>(terms, 1 + round / 2));
    }
    assign();
    for (Index k = 0; k < static_cast<Index>(bases_.size()); ++k) full_.push_back(full_basis(k, lift));
  }
  const std::vector<Eigen::MatrixXf>& bases() const { return full_; }  ///< [cluster] orthonormal, strongest first

 private:
  auto texel(Index i) const { return small_.middleCols(kChannels * i, kChannels); }

  void seed(Index clusters) {
    std::mt19937 random(1);
    std::vector<float> nearest(owner_.size(), std::numeric_limits<float>::max());
    std::size_t pick = random() % owner_.size();
    while (true) {
      Eigen::MatrixXf line = texel(static_cast<Index>(pick)).rowwise().sum();
      if (const float norm = line.norm(); norm > 0.0f) line /= norm;
      bases_.push_back(line);
      if (static_cast<Index>(bases_.size()) == clusters) return;
      double total = 0.0;
      for (std::size_t i = 0; i < owner_.size(); ++i) {
        const auto x = texel(static_cast<Index>(i));
        nearest[i] = std::min(nearest[i], (x - times(line, transposed_times(line, x))).squaredNorm());
        total += static_cast<double>(nearest[i]);
      }
      if (!(total > 0.0)) return;  // fewer distinct texels than clusters
      double at = static_cast<double>(random()) / 4294967296.0 * total;
      pick = 0;
      while (pick + 1 < owner_.size() && (at -= static_cast<double>(nearest[pick])) > 0.0) ++pick;
    }
  }

  void assign() {
    parallel_for(Index{0}, static_cast<Index>(owner_.size()), [&](Index i) {
      const auto x = texel(i);
      const float all = x.squaredNorm();
      float best = std::numeric_limits<float>::max();
      for (std::size_t k = 0; k < bases_.size(); ++k) {
        const float left = all - transposed_times(bases_[k], x).squaredNorm();
        if (left < best) best = left, owner_[static_cast<std::size_t>(i)] = static_cast<Index>(k);
      }
      residual_[static_cast<std::size_t>(i)] = std::max(best, 0.0f);
    });
  }

  void update(Index terms) {
    const auto members = members_of_clusters(owner_, bases_.size(), &residual_);
    parallel_for(std::size_t{0}, bases_.size(), [&](std::size_t k) {
      Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(small_.rows(), small_.rows());
      for (const Index i : members[k]) {
        const Eigen::MatrixXd x = texel(i).cast<double>();
        gram += times_transposed(x, x);
      }
      bases_[k] = leading(gram, terms);
    });
  }

  /// One step of subspace iteration in all dimensions from what the sketch says.
  Eigen::MatrixXf full_basis(Index k, const Eigen::MatrixXf& lift) const {
    std::vector<Index> columns;
    for (std::size_t i = 0; i < owner_.size(); ++i)
      if (owner_[i] == k)
        for (Index c = 0; c < kChannels; ++c) columns.push_back(kChannels * static_cast<Index>(i) + c);
    if (columns.empty()) return Eigen::MatrixXf::Zero(samples_.rows(), terms_);
    const Eigen::MatrixXf x = samples_(Eigen::all, columns);
    const Eigen::MatrixXf start = times(x, transposed_times(x, times(lift, bases_[static_cast<std::size_t>(k)])));
    const Eigen::MatrixXf range =
        times(start, leading(transposed_times(start, start).cast<double>(), start.cols()));  // orthogonal, zeros last
    Eigen::MatrixXf unit = range;
    for (Index c = 0; c < unit.cols(); ++c)
      if (const float norm = unit.col(c).norm(); norm > 0.0f) unit.col(c) /= norm;
    const Eigen::MatrixXf w = transposed_times(unit, x);
    Eigen::MatrixXf basis = times(unit, leading(times_transposed(w, w).cast<double>(), terms_));
    for (Index c = 0; c < basis.cols(); ++c)
      if (basis.col(c).sum() < 0.0f) basis.col(c) = -basis.col(c);
    return basis;
  }

  const Eigen::MatrixXf& samples_;
  Index terms_;
  Eigen::MatrixXf small_;
  std::vector<Index> owner_;
  std::vector<float> residual_;
  std::vector<Eigen::MatrixXf> bases_, full_;
};

}  // namespace

std::shared_ptr<const JointBtf> fit_joint_btf(const Btf& btf, const JointBtfOptions& options,
                                              const std::atomic<bool>& cancel) {
  auto joint = std::make_shared<JointBtf>();
  joint->width = btf.width;
  joint->height = btf.height;
  joint->terms = 1 + options.components;
  const TexelSpace space(btf);
  const Index finest = static_cast<Index>(btf.width) * btf.height,
              step = (finest + kSampledTexels - 1) / kSampledTexels | 1;
  const std::size_t stored = 3 * static_cast<std::size_t>(1 + btf.components);
  const auto sampled = [&](Index first, Index count, Index at_step) {
    Eigen::MatrixXf samples(space.dimensions(), kChannels * ((count + at_step - 1) / at_step));
    parallel_for(Index{0}, samples.cols() / kChannels, [&](Index i) {
      space.read(static_cast<std::size_t>(first + i * at_step) * stored,
                 samples.data() + kChannels * i * samples.rows());
    });
    return samples;
  };
  // Coarser texels are means over many clusters, and outside of what each of these spans: one cluster is theirs.
  const std::vector<BtfLevel> levels = btf_levels(btf.width, btf.height, btf.components);
  const bool apart = options.clusters >= 2 && finest > options.clusters && levels.size() > 1;
  if (cancel) return nullptr;
  const Eigen::MatrixXf samples = sampled(0, finest, step);
  std::vector<Eigen::MatrixXf> found =
      SubspaceClusters(samples, options.clusters - (apart ? 1 : 0), joint->terms).bases();
  if (cancel) return nullptr;
  if (apart) {
    Eigen::MatrixXf coarse(space.dimensions(), 0);
    for (std::size_t l = 1; l < levels.size(); ++l) {  // each level has the same weight
      const Index count = static_cast<Index>(levels[l].width) * levels[l].height,
                  of_level = (count + kSampledTexels / 8 - 1) / (kSampledTexels / 8) | 1;
      const Eigen::MatrixXf own = sampled(static_cast<Index>(levels[l].offset / stored), count, of_level);
      const Index before = coarse.cols();
      coarse.conservativeResize(Eigen::NoChange, before + own.cols());
      coarse.rightCols(own.cols()) = own / std::sqrt(static_cast<float>(own.cols()));
    }
    found.push_back(SubspaceClusters(coarse, 1, joint->terms).bases()[0]);
  }
  if (cancel) return nullptr;
  joint->clusters = static_cast<int>(found.size());
  const Index terms = joint->terms, rows = samples.rows();
  Eigen::MatrixXf bases(rows, joint->clusters * terms);
  for (Index k = 0; k < joint->clusters; ++k) bases.middleCols(k * terms, terms) = found[static_cast<std::size_t>(k)];
  const auto scale = std::sqrt(static_cast<float>(btf.views.size()) * 3.14159265f);  // the cosine's integral is pi
  for (std::size_t v = 0; v < btf.views.size(); ++v) {
    std::vector<float> values(btf.views[v].lights->size() * joint->function_count());
    for (std::size_t f = 0; f < joint->function_count(); ++f) {
      const std::vector<float> of = space.function(bases.col(static_cast<Index>(f)), v);
      for (std::size_t l = 0; l < of.size(); ++l) values[l * joint->function_count() + f] = scale * of[l];
    }
    joint->functions.push_back(std::move(values));
  }
  const auto all = static_cast<Index>(btf.views[0].factors.size() / stored);
  joint->texels.assign(static_cast<std::size_t>(all) * joint->texel_halves(), 0);
  std::vector<double> lost(static_cast<std::size_t>((finest + kBlock - 1) / kBlock), 0.0), energy(lost);
  parallel_for(Index{0}, (all + kBlock - 1) / kBlock, [&](Index b) {
    Eigen::MatrixXf x(rows, kChannels);
    for (Index t = b * kBlock; t < std::min((b + 1) * kBlock, all) && !cancel; ++t) {
      space.read(static_cast<std::size_t>(t) * stored, x.data());
      const Eigen::MatrixXf w = transposed_times(bases, x);
      Index best = 0;
      for (Index k = 1; k < joint->clusters; ++k)
        if (w.middleRows(k * terms, terms).squaredNorm() > w.middleRows(best * terms, terms).squaredNorm()) best = k;
      std::uint16_t* halves = joint->texels.data() + static_cast<std::size_t>(t) * joint->texel_halves();
      halves[0] = half_of_float(static_cast<float>(best));
      for (Index c = 0; c < terms; ++c)
        for (Index k = 0; k < kChannels; ++k)
          halves[1 + c * kChannels + k] = half_of_float(w(best * terms + c, k) / scale);
      if (t >= finest) continue;
      const Eigen::MatrixXf left = x - times(bases.middleCols(best * terms, terms), w.middleRows(best * terms, terms));
      lost[static_cast<std::size_t>(t / kBlock)] += static_cast<double>(left.squaredNorm());
      energy[static_cast<std::size_t>(t / kBlock)] += static_cast<double>(x.squaredNorm());
    }
  });
  if (cancel) return nullptr;
  double sum = 0.0, of = 0.0;
  for (std::size_t b = 0; b < lost.size(); ++b) sum += lost[b], of += energy[b];
  joint->error = of > 0.0 ? std::sqrt(sum / of) : 0.0;
  return joint;
}

glm::vec3 evaluate_joint_btf(const JointBtf& joint, const Btf& btf, int texel, std::size_t view, const glm::vec3& wi) {
  const std::uint16_t* halves = joint.texels.data() + static_cast<std::size_t>(texel) * joint.texel_halves();
  const auto cluster = static_cast<std::size_t>(float_of_half(halves[0]));
  const DirectionWeights lights = btf.views[view].lights->find(wi);
  glm::vec3 rho(0.0f);
  for (std::size_t c = 0; c < static_cast<std::size_t>(joint.terms); ++c) {
    float h = 0.0f;
    for (std::size_t k = 0; k < 3; ++k)
      h += lights.weight[static_cast<int>(k)] *
           joint.functions[view][static_cast<std::size_t>(lights.index[k]) * joint.function_count() +
                                 cluster * static_cast<std::size_t>(joint.terms) + c];
    for (int n = 0; n < 3; ++n) rho[n] += h * float_of_half(halves[1 + 3 * c + static_cast<std::size_t>(n)]);
  }
  return rho;
}

}  // namespace maquette
