#include "render/slf/interactions.h"

#include <tbb/parallel_for.h>

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <map>

#include "render/math/local_pca_fit.h"
#include "render/reference/path_scene.h"
#include "render/slf/interaction_counts.h"
#include "render/slf/texel_materials.h"
#include "scenes/error.h"

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

/// What one cluster of a material makes of light: a linear map for each term.
struct MaterialCluster {
  Eigen::Index terms() const { return btf ? factors.cols() : static_cast<Eigen::Index>(responses.size()); }
  const BtfResponse* btf = nullptr;
  Eigen::MatrixXf factors;                      ///< of a BTF: [(view, factor), 3 channels][term]
  std::vector<const LightResponse*> responses;  ///< of others: [term]
};

/// Texels of one BTF, and what it makes of light there.
struct BtfGroup {
  const TexelGroup* group = nullptr;
  BtfTexels places;
  std::unique_ptr<BtfResponse> response;
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
        out_(std::make_shared<Interactions>()),
        light_metric_(Eigen::MatrixXd::Zero(incident.bins, incident.bins)) {}

  std::shared_ptr<const Interactions> build() {
    const std::vector<TexelGroup> groups = group_texels(scene_, atlas_, options_.texel_m);
    const std::size_t texels = atlas_.texels.size();
    out_->light_cluster.assign(texels, 0);
    out_->material_cluster.assign(texels, 0);
    out_->turns.assign(texels, BtfTurn());
    out_->material_weights = Eigen::MatrixXf::Zero(6, static_cast<Eigen::Index>(texels));
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
    fill_table();
    if (!cancel_) move_scales_to_table();
    return cancel_ ? nullptr : out_;
  }

 private:
  void place(const std::vector<TexelGroup>& groups) {
    for (const TexelGroup& group : groups) {
      if (group.kind != TexelGroup::Kind::btf) continue;
      BtfGroup own;
      own.group = &group;
      own.places = place_btf_texels(scene_, atlas_, group.texels, options_.texel_m);
      for (std::size_t i = 0; i < group.texels.size(); ++i) out_->turns[group.texels[i]] = own.places.turns[i];
      btfs_.push_back(std::move(own));
    }
  }

  /// The light in the materials' frames.
  void turn_light() {
    const auto texels = static_cast<Eigen::Index>(atlas_.texels.size());
    arriving_.resize(3 * incident_.bins, texels);
    std::map<BtfTurn, Eigen::MatrixXf> turned;
    const Eigen::MatrixXf from_means = spline_.from_means(kTurnSamples);
    for (const BtfTurn& turn : out_->turns)
      if (turn != BtfTurn() && !turned.contains(turn)) turned[turn] = turned_means(spline_, turn) * from_means;
    tbb::parallel_for(Eigen::Index{0}, texels, [&](Eigen::Index t) {
      const std::span<const float> values = incident_.texel(static_cast<std::size_t>(t));
      const BtfTurn& turn = out_->turns[static_cast<std::size_t>(t)];
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
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> solver(light_metric_);
    const double most = solver.eigenvalues()[solver.eigenvalues().size() - 1];
    const Eigen::VectorXd roots = most > 0.0 ? solver.eigenvalues().cwiseMax(kLeastSeen * most).cwiseSqrt().eval()
                                             : Eigen::VectorXd::Ones(incident_.bins).eval();  // black materials
    const Eigen::MatrixXf into = (roots.asDiagonal() * solver.eigenvectors().transpose()).cast<float>();
    out_of_metric_ = (solver.eigenvectors() * roots.cwiseInverse().asDiagonal()).cast<float>();
    using Colors = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
    tbb::parallel_for(Eigen::Index{0}, arriving_.cols(), [&](Eigen::Index t) {
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
    for (const MaterialCluster& cluster : clusters_) most = std::max(most, static_cast<int>(cluster.terms()));
    return most;
  }

  /// Of each BTF: as many as the table has room for beside the clusters of the light and the other materials.
  int clusters_of_btf(const InteractionCounts& counts) const {
    const std::size_t pair = static_cast<std::size_t>(incident_.side * incident_.side) * kTableBytes *
                             static_cast<std::size_t>((1 + counts.light_components) * material_terms(counts));
    const std::size_t most = options_.most_bytes / pair / static_cast<std::size_t>(std::max(counts.light_clusters, 1));
    const int room = static_cast<int>(std::clamp<std::size_t>(most, 1, kMostMaterialClusters));
    return std::max((room - static_cast<int>(uniform_clusters_)) / std::max(static_cast<int>(btfs_.size()), 1), 1);
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
    out_->light_clusters = light_.pca.cluster_count();
    out_->light_terms = 1 + static_cast<int>(light_.weights.rows());
    out_->light_weights = light_.weights;
    for (std::size_t t = 0; t < light_.owner.size(); ++t)
      out_->light_cluster[t] = static_cast<std::uint16_t>(light_.owner[t]);
    return true;
  }

  void compress_materials() {
    out_->material_terms = material_terms(counts_);
    out_->material_weights.conservativeResizeLike(
        Eigen::MatrixXf::Zero(3 * out_->material_terms, out_->material_weights.cols()));
    const int each = clusters_of_btf(counts_);
    for (BtfGroup& btf : btfs_) {
      if (cancel_) return;
      compress_btf(&btf, each);
    }
    out_->material_clusters = static_cast<int>(clusters_.size());
  }

  void add_uniform(const TexelGroup& group) {
    const int samples = response_samples(group.point);
    const bool linear = group.kind == TexelGroup::Kind::base_linear;
    MaterialCluster cluster;
    if (linear) {
      SurfacePoint black = group.point, white = group.point;
      black.analytic.diffuse = glm::vec3(0.0f);
      white.analytic.diffuse = glm::vec3(1.0f);
      auto rest = std::make_unique<LightResponse>(compute_response(black, spline_, samples));
      auto base = std::make_unique<LightResponse>(compute_response(white, spline_, samples));
      for (std::size_t c = 0; c < 3; ++c) base->channels[c] -= rest->channels[c];
      cluster.responses = {rest.get(), base.get()};
      responses_.push_back(std::move(rest));
      responses_.push_back(std::move(base));
    } else {
      SurfacePoint own = group.point;
      own.tint = glm::vec3(1.0f);
      responses_.push_back(std::make_unique<LightResponse>(compute_response(own, spline_, samples)));
      cluster.responses = {responses_.back().get()};
    }
    for (std::size_t i = 0; i < group.texels.size(); ++i) {
      const std::uint32_t t = group.texels[i];
      out_->material_cluster[t] = static_cast<std::uint16_t>(clusters_.size());
      for (int c = 0; c < 3; ++c) {
        out_->material_weights(c, t) = linear ? 1.0f : group.scales[i][c];
        if (linear) out_->material_weights(3 + c, t) = group.scales[i][c];
      }
    }
    const auto share = static_cast<double>(group.texels.size());
    Eigen::VectorXd area(incident_.bins);
    for (int b = 0; b < incident_.bins; ++b) area[b] = spline_.lumisphere().solid_angle(b);
    for (const LightResponse* response : cluster.responses)
      for (const Eigen::MatrixXf& channel : response->channels) {
        const Eigen::MatrixXd r = channel.cast<double>();
        light_metric_ += share * r.transpose() * area.asDiagonal() * r;
      }
    clusters_.push_back(std::move(cluster));
    ++uniform_clusters_;
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
      light_metric_ += share * area * l.transpose() * moments[static_cast<std::size_t>(v)] * l;
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
    own.response = std::make_unique<BtfResponse>(btf, spline_, BtfTurn());
    const std::size_t terms = static_cast<std::size_t>(btf.components) + 1, views = btf.views.size();
    own.factors.resize(static_cast<Eigen::Index>(3 * terms * views), static_cast<Eigen::Index>(group.texels.size()));
    tbb::parallel_for(std::size_t{0}, group.texels.size(), [&](std::size_t i) {
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
    const std::size_t first = clusters_.size();
    for (int k = 0; k < fit.pca.cluster_count(); ++k) {
      MaterialCluster cluster;
      cluster.btf = btf->response.get();
      cluster.factors.resize(fit.pca.dimension(), 1 + fit.weights.rows());
      cluster.factors.col(0) = fit.pca.mean(k);
      if (fit.weights.rows() > 0) cluster.factors.rightCols(fit.weights.rows()) = fit.pca.components(k);
      clusters_.push_back(std::move(cluster));
    }
    for (std::size_t i = 0; i < group.texels.size(); ++i) {
      const std::uint32_t t = group.texels[i];
      out_->material_cluster[t] = static_cast<std::uint16_t>(first + static_cast<std::size_t>(fit.owner[i]));
      for (int c = 0; c < 3; ++c) {
        out_->material_weights(c, t) = group.scales[i][c];
        for (Eigen::Index k = 0; k < fit.weights.rows(); ++k)
          out_->material_weights(3 * (k + 1) + c, t) =
              fit.weights(k, static_cast<Eigen::Index>(i)) * group.scales[i][c];
      }
    }
  }

  void fill_table() {
    Interactions& o = *out_;
    o.table = Eigen::MatrixXf::Zero(3 * incident_.bins, static_cast<Eigen::Index>(o.column(o.light_clusters, 0, 0, 0)));
    tbb::parallel_for(0, o.light_clusters, [&](int light) {
      const Eigen::VectorXf mean = light_.pca.mean(light);
      const Eigen::MatrixXf components = light_.pca.components(light);
      using Colors = Eigen::Matrix<float, Eigen::Dynamic, 3, Eigen::RowMajor>;
      for (int i = 0; i < o.light_terms && !cancel_; ++i) {
        const Eigen::VectorXf term = i == 0 ? mean : Eigen::VectorXf(components.col(i - 1));
        Colors colors = out_of_metric_ * Eigen::Map<const Colors>(term.data(), incident_.bins, 3);
        fill_columns(light, i, Eigen::Map<const Eigen::VectorXf>(colors.data(), colors.size()));
      }
    });
  }

  /// What all material clusters make of one term of the light, [3 bin + channel].
  void fill_columns(int light, int light_term, const Eigen::VectorXf& vector) {
    using Channel = Eigen::Map<Eigen::VectorXf, 0, Eigen::InnerStride<>>;
    Interactions& o = *out_;
    for (Eigen::Index c = 0; c < 3; ++c) {
      const Eigen::VectorXf incident = Eigen::Map<const Eigen::VectorXf, 0, Eigen::InnerStride<>>(
          vector.data() + c, incident_.bins, Eigen::InnerStride<>(3));
      std::map<const BtfResponse*, Eigen::VectorXf> of_btf;
      for (const BtfGroup& btf : btfs_) of_btf[btf.response.get()] = btf.response->light_of_terms(incident);
      for (int m = 0; m < o.material_clusters; ++m) {
        const MaterialCluster& cluster = clusters_[static_cast<std::size_t>(m)];
        for (Eigen::Index k = 0; k < cluster.terms(); ++k) {
          const auto column = static_cast<Eigen::Index>(o.column(light, m, light_term, static_cast<int>(k)));
          Channel out(o.table.col(column).data() + c, incident_.bins, Eigen::InnerStride<>(3));
          if (cluster.btf)
            out = cluster.btf->apply_factors(cluster.factors.col(k), c, of_btf.at(cluster.btf));
          else
            out = cluster.responses[static_cast<std::size_t>(k)]->channels[static_cast<std::size_t>(c)] * incident;
        }
      }
    }
  }

  /// Weights of each term of each cluster are at most 1 afterwards: sunlit and dark clusters then both fit half floats.
  void move_scales_to_table() {
    Interactions& o = *out_;
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
    tbb::parallel_for(0, o.light_clusters, [&](int light) {
      for (int m = 0; m < o.material_clusters; ++m)
        for (int i = 0; i < o.light_terms; ++i)
          for (int k = 0; k < o.material_terms; ++k)
            o.table.col(static_cast<Eigen::Index>(o.column(light, m, i, k))) *=
                (i == 0 ? 1.0f : of_light(i - 1, light)) * of_material(k, m);
    });
  }

  const PathScene& scene_;
  const LightFieldAtlas& atlas_;
  const IncidentField& incident_;
  const InteractionOptions& options_;
  const std::atomic<bool>& cancel_;
  DirectionSpline spline_;
  std::shared_ptr<Interactions> out_;
  InteractionCounts counts_;
  std::vector<BtfGroup> btfs_;
  Eigen::MatrixXf arriving_;       ///< [3 bin + channel][texel] in the materials' frames, until it is compressed
  Eigen::MatrixXd light_metric_;   ///< [bin][bin] squared outgoing light of light, mean over materials, any unit
  Eigen::MatrixXf out_of_metric_;  ///< from its compressed form to light
  LocalPcaFit light_;
  std::vector<MaterialCluster> clusters_;  ///< of uniform materials, then of BTFs
  std::size_t uniform_clusters_ = 0;
  std::vector<std::unique_ptr<LightResponse>> responses_;
};

}  // namespace

Eigen::VectorXf Interactions::decode(std::size_t texel) const {
  const auto t = static_cast<Eigen::Index>(texel);
  Eigen::VectorXf sum = Eigen::VectorXf::Zero(table.rows());
  for (int i = 0; i < light_terms; ++i)
    for (int k = 0; k < material_terms; ++k) {
      const auto from =
          table.col(static_cast<Eigen::Index>(column(light_cluster[texel], material_cluster[texel], i, k)));
      for (int c = 0; c < 3; ++c) {
        const float weight = (i == 0 ? 1.0f : light_weights(i - 1, t)) * material_weights(3 * k + c, t);
        for (Eigen::Index row = c; row < sum.size(); row += 3) sum[row] += weight * from[row];
      }
    }
  return sum;
}

std::shared_ptr<const Interactions> compute_interactions(const PathScene& scene, const LightFieldAtlas& atlas,
                                                         const IncidentField& incident,
                                                         const InteractionOptions& options,
                                                         const std::atomic<bool>& cancel) {
  return Builder(scene, atlas, incident, options, cancel).build();
}

double interaction_error(const Interactions& interactions, const OutgoingField& field, int side, std::size_t step) {
  const DirectionSpline spline{Lumisphere(side)};
  const Lumisphere& sphere = spline.lumisphere();
  double squares = 0.0, sum = 0.0, all = 0.0;
  for (std::size_t t = 0; t < interactions.turns.size(); t += step) {
    const Eigen::VectorXf own = interactions.decode(t);
    const auto truth = field.radiance.col(static_cast<Eigen::Index>(t));
    for (int b = 0; b < sphere.count(); ++b) {
      const double area = sphere.solid_angle(b);
      glm::dvec3 a(0.0), e(0.0);
      for (const DirectionSpline::Share& s : spline.shares(interactions.turns[t].to_btf(sphere.direction(b))))
        for (int c = 0; c < 3; ++c) a[c] += static_cast<double>(s.weight) * static_cast<double>(own[3 * s.bin + c]);
      for (const DirectionSpline::Share& s : spline.shares(sphere.direction(b)))
        for (int c = 0; c < 3; ++c) e[c] += static_cast<double>(s.weight) * static_cast<double>(truth[3 * s.bin + c]);
      squares += area * glm::dot(a - e, a - e);
      sum += area * (e.x + e.y + e.z);
      all += 3.0 * area;
    }
  }
  return sum > 0.0 ? std::sqrt(squares / all) / (sum / all) : 0.0;
}

}  // namespace maquette
