#include "render/slf/interaction_terms.h"

#include <algorithm>
#include <cmath>
#include <map>

#include "render/math/local_pca_fit.h"
#include "render/reference/path_scene.h"
#include "render/slf/interaction_counts.h"
#include "render/slf/texel_materials.h"
#include "scenes/error.h"
#include "scenes/linear_algebra.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr int kTurnSamples = 4;         ///< squared, of a bin
constexpr std::size_t kTableBytes = 8;  ///< of a coefficient on the device: three half floats, padded
constexpr int kMostMaterialClusters = 256;
constexpr std::size_t kMetricTexels = 512;  ///< that the metrics of both compressions are means over

/// Of the metric's largest eigenvalue: light that is seen less counts as if it were seen so much.
constexpr double kLeastSeen = 1e-6;

/// [bin][bin]: means of the bins of a turned frame, from the coefficients of light.
Eigen::MatrixXf turned_means(const DirectionSpline& spline, const BtfTurn& turn) {
  const int bins = spline.lumisphere().count();
  Eigen::MatrixXf means = Eigen::MatrixXf::Zero(bins, bins);
  for (int k = 0; k < bins; ++k)
    for (const DirectionSpline::BinSample& s : spline.bin_samples(k, kTurnSamples))
      for (const DirectionSpline::Share& share : spline.shares(turn.from_btf(s.direction)))
        means(k, share.bin) += s.weight * share.weight;
  return means;
}

/// Texels of one BTF, and what it makes of light there.
struct BtfGroup {
  const TexelGroup* group = nullptr;
  BtfTexels places;
  std::shared_ptr<const BtfResponse> response;
  Eigen::MatrixXf factors;  ///< [(view, factor), 3 channels][texel]
  Eigen::VectorXf measure;  ///< of their errors: squared outgoing light of one texel
};

class Builder {
 public:
  Builder(const PathScene& scene, const LightFieldAtlas& atlas, const IncidentField& incident,
          const InteractionOptions& options, const std::atomic<bool>& cancel)
      : scene_(scene),
        atlas_(atlas),
        incident_(incident),
        options_(options),
        cancel_(cancel),
        spline_(Lumisphere(incident.side)),
        out_(std::make_shared<InteractionTerms>()),
        codes_(out_->codes),
        light_metric_(Eigen::MatrixXd::Zero(incident.bins, incident.bins)) {}

  std::shared_ptr<const InteractionTerms> build() {
    const std::vector<TexelGroup> groups = group_texels(scene_, atlas_, options_.texel_m);
    const std::size_t texels = atlas_.texels.size();
    codes_.light_cluster.assign(texels, 0);
    codes_.material_cluster.assign(texels, 0);
    codes_.turns.assign(texels, BtfTurn());
    codes_.material_weights = Eigen::MatrixXf::Zero(6, static_cast<Eigen::Index>(texels));
    for (const TexelGroup& group : groups) {
      if (group.kind == TexelGroup::Kind::each)
        throw Error("material " + group.point.material->values.name,
                    "it differs from texel to texel in more than its base colour, which slf.route=clusters cannot hold",
                    "take --set slf.route=fields");
    }
    place(groups);
    turn_light();
    for (const TexelGroup& group : groups)
      if (group.kind == TexelGroup::Kind::btf)
        read_btf(group);
      else
        add_uniform(group);
    if (cancel_) return nullptr;
    weigh_light();
    counts_ = options_.counts ? *options_.counts : best_counts();
    compress_materials();
    if (cancel_ || !compress_light()) return nullptr;
    take_light_terms();
    move_scales_to_terms();
    return cancel_ ? nullptr : out_;
  }

 private:
  void place(const std::vector<TexelGroup>& groups) {
    for (const TexelGroup& group : groups) {
      if (group.kind != TexelGroup::Kind::btf) continue;
      BtfGroup own;
      own.group = &group;
      own.places = place_btf_texels(scene_, atlas_, group.texels, options_.texel_m);
      for (std::size_t i = 0; i < group.texels.size(); ++i) codes_.turns[group.texels[i]] = own.places.turns[i];
      btfs_.push_back(std::move(own));
    }
  }

  /// The light in the materials' frames.
  void turn_light() {
    const auto texels = static_cast<Eigen::Index>(atlas_.texels.size());
    arriving_.resize(3 * incident_.bins, texels);
    std::map<BtfTurn, Eigen::MatrixXf> turned;
    const Eigen::MatrixXf from_means = spline_.from_means(kTurnSamples);
    for (const BtfTurn& turn : codes_.turns)
      if (turn != BtfTurn() && !turned.contains(turn)) turned[turn] = times(turned_means(spline_, turn), from_means);
    parallel_for(Eigen::Index{0}, texels, [&](Eigen::Index t) {
      const std::span<const float> values = incident_.texel(static_cast<std::size_t>(t));
      const BtfTurn& turn = codes_.turns[static_cast<std::size_t>(t)];
      using Colors = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
      const Eigen::Map<const Colors> in(values.data(), incident_.bins, 3);
      Eigen::Map<Colors> own(arriving_.col(t).data(), incident_.bins, 3);
      if (turn == BtfTurn())
        own = in;
      else
        own.noalias() = turned.at(turn) * in;
    });
  }

  /// Brings the light into a space where distances are those of outgoing light: by what the materials see of it.
  void weigh_light() {
    const SymmetricEigen solver(light_metric_);
    const double most = solver.eigenvalues()[solver.eigenvalues().size() - 1];
    const Eigen::VectorXd roots = most > 0.0 ? solver.eigenvalues().cwiseMax(kLeastSeen * most).cwiseSqrt().eval()
                                             : Eigen::VectorXd::Ones(incident_.bins).eval();  // black materials
    const Eigen::MatrixXf into = (roots.asDiagonal() * solver.eigenvectors().transpose()).cast<float>();
    out_of_metric_ = (solver.eigenvectors() * roots.cwiseInverse().asDiagonal()).cast<float>();
    using Colors = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
    parallel_for(Eigen::Index{0}, arriving_.cols(), [&](Eigen::Index t) {
      Eigen::Map<Colors> own(arriving_.col(t).data(), incident_.bins, 3);
      own = (into * own).eval();
    });
  }

  LocalPcaOptions pca_options(int clusters, int components, int rounds = 14) const {
    LocalPcaOptions o;
    o.clusters = clusters;
    o.components = components;
    o.rounds = rounds;
    o.stop = [this] { return cancel_.load(); };
    return o;
  }

  int material_terms(const InteractionCounts& counts) const {
    int most = btfs_.empty() ? 1 : 1 + counts.material_components;
    for (const MaterialCluster& cluster : out_->materials) most = std::max(most, static_cast<int>(cluster.terms()));
    return most;
  }

  /// Of each BTF: as many as the table has room for beside the clusters of the light and the other materials, which
  /// are all that is there before BTFs are compressed.
  int clusters_of_btf(const InteractionCounts& counts) const {
    const std::size_t pair = static_cast<std::size_t>(incident_.side * incident_.side) * kTableBytes *
                             static_cast<std::size_t>((1 + counts.light_components) * material_terms(counts));
    const std::size_t most = options_.most_bytes / pair / static_cast<std::size_t>(std::max(counts.light_clusters, 1));
    const int room = static_cast<int>(std::clamp<std::size_t>(most, 1, kMostMaterialClusters));
    return std::max((room - static_cast<int>(out_->materials.size())) / std::max(static_cast<int>(btfs_.size()), 1), 1);
  }

  InteractionCounts best_counts() const {
    std::vector<InteractionMaterial> materials;
    for (const BtfGroup& btf : btfs_)
      materials.push_back(
          {sketch_interactions(btf.factors, btf.measure), static_cast<double>(btf.group->texels.size())});
    return choose_interaction_counts(
        sketch_interactions(arriving_, {}), materials,
        [this](const InteractionCounts& counts) { return clusters_of_btf(counts); }, cancel_);
  }

  bool compress_light() {
    light_ = fit_local_pca(arriving_, Eigen::VectorXf::Ones(arriving_.rows()),
                           pca_options(counts_.light_clusters, counts_.light_components));
    arriving_.resize(0, 0);
    if (cancel_) return false;
    codes_.light_clusters = light_.pca.cluster_count();
    codes_.light_terms = 1 + static_cast<int>(light_.weights.rows());
    codes_.light_weights = light_.weights;
    for (std::size_t t = 0; t < light_.owner.size(); ++t)
      codes_.light_cluster[t] = static_cast<std::uint16_t>(light_.owner[t]);
    return true;
  }

  void compress_materials() {
    codes_.material_terms = material_terms(counts_);
    codes_.material_weights.conservativeResizeLike(
        Eigen::MatrixXf::Zero(3 * codes_.material_terms, codes_.material_weights.cols()));
    const int each = clusters_of_btf(counts_);
    for (BtfGroup& btf : btfs_) {
      if (cancel_) return;
      compress_btf(&btf, each);
    }
    codes_.material_clusters = static_cast<int>(out_->materials.size());
  }

  void add_uniform(const TexelGroup& group) {
    const int samples = response_samples(group.point);
    const bool linear = group.kind == TexelGroup::Kind::base_linear;
    MaterialCluster cluster;
    if (linear) {
      SurfacePoint black = group.point, white = group.point;
      black.analytic.diffuse = glm::vec3(0.0f);
      white.analytic.diffuse = glm::vec3(1.0f);
      LightResponse rest = compute_response(black, spline_, samples), base = compute_response(white, spline_, samples);
      for (std::size_t c = 0; c < 3; ++c) base.channels[c] -= rest.channels[c];
      cluster.responses = {std::move(rest), std::move(base)};
    } else {
      SurfacePoint own = group.point;
      own.tint = glm::vec3(1.0f);
      cluster.responses = {compute_response(own, spline_, samples)};
    }
    for (std::size_t i = 0; i < group.texels.size(); ++i) {
      const std::uint32_t t = group.texels[i];
      codes_.material_cluster[t] = static_cast<std::uint16_t>(out_->materials.size());
      for (int c = 0; c < 3; ++c) {
        codes_.material_weights(c, t) = linear ? 1.0f : group.scales[i][c];
        if (linear) codes_.material_weights(3 + c, t) = group.scales[i][c];
      }
    }
    const auto share = static_cast<double>(group.texels.size());
    Eigen::VectorXd area(incident_.bins);
    for (int b = 0; b < incident_.bins; ++b) area[b] = spline_.lumisphere().solid_angle(b);
    for (const LightResponse& response : cluster.responses)
      for (const Eigen::MatrixXf& channel : response.channels) {
        const Eigen::MatrixXd r = channel.cast<double>();
        light_metric_ += transposed_times(r, share * area.asDiagonal() * r);
      }
    out_->materials.push_back(std::move(cluster));
  }

  /// Adds what a BTF's texels see of light: sum over views of area * L^T E[F F^T] L, with its factors F and the light L
  /// of its terms. Returns the measure of its factors: area * E[(L light)^2].
  Eigen::VectorXf add_btf_metric(const TexelGroup& group, const BtfResponse& response, const Eigen::MatrixXf& factors,
                                 const std::vector<double>& areas) {
    const auto views = static_cast<Eigen::Index>(areas.size()), terms = factors.rows() / 3 / views;
    const std::size_t count = std::min(group.texels.size(), kMetricTexels);
    Eigen::VectorXf measure = Eigen::VectorXf::Zero(factors.rows());
    std::vector<Eigen::MatrixXd> moments(areas.size(), Eigen::MatrixXd::Zero(terms, terms));
    for (std::size_t i = 0; i < count; ++i) {
      const std::size_t at = i * group.texels.size() / count;
      using Colors = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
      const Eigen::Map<const Colors> light(arriving_.col(group.texels[at]).data(), incident_.bins, 3);
      const Eigen::Map<const Colors> own(factors.col(static_cast<Eigen::Index>(at)).data(), views * terms, 3);
      for (Eigen::Index c = 0; c < 3; ++c) {
        const Eigen::VectorXf seen = response.light_of_terms(light.col(c));
        for (Eigen::Index r = 0; r < seen.size(); ++r) measure[3 * r + c] += seen[r] * seen[r];
        for (Eigen::Index v = 0; v < views; ++v) {
          const Eigen::VectorXd f = own.col(c).segment(v * terms, terms).cast<double>();
          moments[static_cast<std::size_t>(v)] += f * f.transpose();
        }
      }
    }
    const double share =
        static_cast<double>(group.texels.size()) / static_cast<double>(std::max<std::size_t>(count, 1));
    for (Eigen::Index v = 0; v < views; ++v) {
      const double area = areas[static_cast<std::size_t>(v)];
      const Eigen::MatrixXd l = response.light().middleRows(v * terms, terms).cast<double>();
      light_metric_ += share * area * times(transposed_times(l, moments[static_cast<std::size_t>(v)]), l);
      measure.segment(3 * v * terms, 3 * terms) *=
          static_cast<float>(area / static_cast<double>(std::max<std::size_t>(count, 1)));
    }
    const float largest = measure.maxCoeff();
    return largest > 0.0f ? measure.cwiseMax(static_cast<float>(kLeastSeen) * largest).eval()
                          : Eigen::VectorXf::Ones(measure.size()).eval();
  }

  void read_btf(const TexelGroup& group) {
    BtfGroup& own = *std::ranges::find(btfs_, &group, &BtfGroup::group);
    const Btf& btf = *group.point.material->btf;
    own.response = std::make_shared<const BtfResponse>(btf, spline_, BtfTurn());
    const std::size_t terms = static_cast<std::size_t>(btf.components) + 1, views = btf.views.size();
    own.factors.resize(static_cast<Eigen::Index>(3 * terms * views), static_cast<Eigen::Index>(group.texels.size()));
    parallel_for(std::size_t{0}, group.texels.size(), [&](std::size_t i) {
      if (cancel_) return;
      std::vector<glm::vec3> colors(terms);
      for (std::size_t v = 0; v < views; ++v) {
        read_btf_factors(btf, btf.views[v], own.places.lookups[i], colors.data());
        for (std::size_t k = 0; k < terms; ++k)
          for (int c = 0; c < 3; ++c)
            own.factors(static_cast<Eigen::Index>(3 * (v * terms + k)) + c, static_cast<Eigen::Index>(i)) =
                colors[k][c];
      }
    });
    if (!cancel_)
      own.measure = add_btf_metric(group, *own.response, own.factors, btf.view_mesh.quadrature().solid_angle);
  }

  void compress_btf(BtfGroup* btf, int clusters) {
    const TexelGroup& group = *btf->group;
    const LocalPcaFit fit =
        fit_local_pca(btf->factors, btf->measure, pca_options(clusters, counts_.material_components));
    btf->factors.resize(0, 0);
    const std::size_t first = out_->materials.size();
    for (int k = 0; k < fit.pca.cluster_count(); ++k) {
      MaterialCluster cluster;
      cluster.btf = btf->response;
      cluster.factors.resize(fit.pca.dimension(), 1 + fit.weights.rows());
      cluster.factors.col(0) = fit.pca.mean(k);
      if (fit.weights.rows() > 0) cluster.factors.rightCols(fit.weights.rows()) = fit.pca.components(k);
      out_->materials.push_back(std::move(cluster));
    }
    for (std::size_t i = 0; i < group.texels.size(); ++i) {
      const std::uint32_t t = group.texels[i];
      codes_.material_cluster[t] = static_cast<std::uint16_t>(first + static_cast<std::size_t>(fit.owner[i]));
      for (int c = 0; c < 3; ++c) {
        codes_.material_weights(c, t) = group.scales[i][c];
        for (Eigen::Index k = 0; k < fit.weights.rows(); ++k)
          codes_.material_weights(3 * (k + 1) + c, t) =
              fit.weights(k, static_cast<Eigen::Index>(i)) * group.scales[i][c];
      }
    }
  }

  /// What the clusters of the light stand for, as it arrives.
  void take_light_terms() {
    using Colors = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
    const Eigen::Index terms = codes_.light_terms;
    out_->light.resize(3 * incident_.bins, terms * codes_.light_clusters);
    for (int k = 0; k < codes_.light_clusters; ++k) {
      out_->light.col(k * terms) = light_.pca.mean(k);
      if (terms > 1) out_->light.middleCols(k * terms + 1, terms - 1) = light_.pca.components(k);
      for (Eigen::Index i = 0; i < terms; ++i) {
        Eigen::Map<Colors> colors(out_->light.col(k * terms + i).data(), incident_.bins, 3);
        colors = (out_of_metric_ * colors).eval();
      }
    }
  }

  /// Weights of each term of each cluster are at most 1 afterwards.
  void move_scales_to_terms() {
    InteractionCodes& o = codes_;
    const auto texels = static_cast<Eigen::Index>(o.light_cluster.size());
    Eigen::MatrixXf of_light = Eigen::MatrixXf::Zero(o.light_terms - 1, o.light_clusters),
                    of_material = Eigen::MatrixXf::Zero(o.material_terms, o.material_clusters);
    for (const bool divides : {false, true})
      for (Eigen::Index t = 0; t < texels; ++t) {
        const auto at = static_cast<std::size_t>(t);
        auto light = of_light.col(o.light_cluster[at]), material = of_material.col(o.material_cluster[at]);
        for (Eigen::Index i = 0; i < light.size(); ++i)
          if (divides)
            o.light_weights(i, t) /= light[i] > 0.0f ? light[i] : 1.0f;
          else
            light[i] = std::max(light[i], std::abs(o.light_weights(i, t)));
        for (Eigen::Index k = 0; k < material.size(); ++k) {
          auto weights = o.material_weights.col(t).segment<3>(3 * k);
          if (divides)
            weights /= material[k] > 0.0f ? material[k] : 1.0f;
          else
            material[k] = std::max(material[k], weights.cwiseAbs().maxCoeff());
        }
      }
    for (int k = 0; k < o.light_clusters; ++k)
      for (int i = 1; i < o.light_terms; ++i) out_->light.col(k * o.light_terms + i) *= of_light(i - 1, k);
    for (int m = 0; m < o.material_clusters; ++m) {
      MaterialCluster& cluster = out_->materials[static_cast<std::size_t>(m)];
      for (int k = 0; k < static_cast<int>(cluster.terms()); ++k)
        if (cluster.btf)
          cluster.factors.col(k) *= of_material(k, m);
        else
          for (Eigen::MatrixXf& channel : cluster.responses[static_cast<std::size_t>(k)].channels)
            channel *= of_material(k, m);
    }
  }

  const PathScene& scene_;
  const LightFieldAtlas& atlas_;
  const IncidentField& incident_;
  const InteractionOptions& options_;
  const std::atomic<bool>& cancel_;
  DirectionSpline spline_;
  std::shared_ptr<InteractionTerms> out_;
  InteractionCodes& codes_;
  InteractionCounts counts_;
  std::vector<BtfGroup> btfs_;
  Eigen::MatrixXf arriving_;       ///< [3 bin + channel][texel] in the materials' frames, until it is compressed
  Eigen::MatrixXd light_metric_;   ///< [bin][bin] squared outgoing light of light, mean over materials, any unit
  Eigen::MatrixXf out_of_metric_;  ///< from its compressed form to light
  LocalPcaFit light_;
};

}  // namespace

std::shared_ptr<const InteractionTerms> compress_interactions(const PathScene& scene, const LightFieldAtlas& atlas,
                                                              const IncidentField& incident,
                                                              const InteractionOptions& options,
                                                              const std::atomic<bool>& cancel) {
  return Builder(scene, atlas, incident, options, cancel).build();
}

}  // namespace maquette
