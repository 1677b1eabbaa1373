#include "render/slf/outgoing.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>

#include "render/reference/scattering.h"
#include "render/slf/texel_materials.h"
#include "scenes/error.h"
#include "scenes/linear_algebra.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr std::size_t kBatch = 256;  ///< texels

struct Batch {
  std::array<Eigen::MatrixXf, 3> in, out;
};

Batch gather(const IncidentField& incident, std::span<const std::uint32_t> texels) {
  Batch batch;
  const auto n = static_cast<Eigen::Index>(texels.size());
  for (std::size_t c = 0; c < 3; ++c) {
    batch.in[c].resize(incident.bins, n);
    batch.out[c] = Eigen::MatrixXf::Zero(incident.bins, n);
  }
  for (Eigen::Index i = 0; i < n; ++i) {
    const std::span<const float> values = incident.texel(texels[static_cast<std::size_t>(i)]);
    for (Eigen::Index b = 0; b < incident.bins; ++b)
      for (std::size_t c = 0; c < 3; ++c) batch.in[c](b, i) = values[static_cast<std::size_t>(3 * b) + c];
  }
  return batch;
}

/// One group's texels, batch by batch.
class GroupShader {
 public:
  GroupShader(const IncidentField& incident, const DirectionSpline& spline, const OutgoingOptions& options,
              OutgoingField* out)
      : incident_(incident), spline_(spline), options_(options), out_(*out) {}

  void shade(const TexelGroup& group, const std::atomic<bool>& cancel) {
    const int samples = response_samples(group.point);
    std::vector<LightTransport> transports;
    if (group.kind == TexelGroup::Kind::base_linear) {
      // Linear in the base colour: the lobe over black, and what white adds.
      SurfacePoint black = group.point, white = group.point;
      black.analytic.diffuse = glm::vec3(0.0f);
      white.analytic.diffuse = glm::vec3(1.0f);
      const LightResponse rest = compute_response(black, spline_, samples);
      LightResponse base = compute_response(white, spline_, samples);
      for (std::size_t c = 0; c < 3; ++c) base.channels[c] -= rest.channels[c];
      transports = {make(base), make(rest)};
    } else if (group.kind == TexelGroup::Kind::scaled) {
      SurfacePoint own = group.point;
      own.tint = glm::vec3(1.0f);
      transports = {make(compute_response(own, spline_, samples))};
    }
    const std::size_t count = group.texels.size(), batch = kBatch;
    std::vector<std::size_t> used((count + batch - 1) / batch, 0);
    parallel_for(std::size_t{0}, used.size(), [&](std::size_t b) {
      if (cancel) return;
      const std::size_t first = b * batch, size = std::min(batch, count - first);
      used[b] = shade_batch(group, transports, first, size);
    });
    coefficients_ += std::accumulate(used.begin(), used.end(), std::size_t{0});
  }
  /// Shades texels that share nothing, one by one.
  void shade_each(const PathScene& scene, const LightFieldAtlas& atlas, const TexelGroup& group,
                  const std::atomic<bool>& cancel);
  /// Shades texels of a BTF, those whose frames lie the same way together.
  void shade_btf(const PathScene& scene, const LightFieldAtlas& atlas, const TexelGroup& group,
                 const std::atomic<bool>& cancel);
  std::size_t coefficients() const { return coefficients_; }

 private:
  LightTransport make(const LightResponse& response) const {
    return {response, spline_.lumisphere(), options_.basis, options_.haar_error};
  }
  std::size_t shade_batch(const TexelGroup& group, const std::vector<LightTransport>& transports, std::size_t first,
                          std::size_t size) {
    const std::span<const std::uint32_t> texels = std::span(group.texels).subspan(first, size);
    Batch batch = gather(incident_, texels);
    std::size_t used = transports[0].apply(batch.in, &batch.out);
    for (std::size_t i = 0; i < size; ++i)
      for (std::size_t c = 0; c < 3; ++c)
        batch.out[c].col(static_cast<Eigen::Index>(i)) *= group.scales[first + i][static_cast<int>(c)];
    if (transports.size() > 1) used = std::max(used, transports[1].apply(batch.in, &batch.out));
    put(batch, texels);
    return used;
  }
  void put(const Batch& batch, std::span<const std::uint32_t> texels) {
    for (std::size_t i = 0; i < texels.size(); ++i)
      for (Eigen::Index bin = 0; bin < incident_.bins; ++bin)
        for (std::size_t c = 0; c < 3; ++c)
          out_.radiance(3 * bin + static_cast<Eigen::Index>(c), texels[i]) =
              batch.out[c](bin, static_cast<Eigen::Index>(i));
  }

  const IncidentField& incident_;
  const DirectionSpline& spline_;
  const OutgoingOptions& options_;
  OutgoingField& out_;
  std::size_t coefficients_ = 0;
};

/// Orthonormal Haar transform of one axis of length n (a power of two): [coefficient][sample].
Eigen::MatrixXf haar_matrix(int n) {
  Eigen::MatrixXf h = Eigen::MatrixXf::Zero(n, n);
  h.row(0).setConstant(1.0f / std::sqrt(static_cast<float>(n)));
  for (int width = n, row = 1; width > 1; width /= 2)
    for (int at = 0; at < n; at += width, ++row) {
      h.block(row, at, 1, width / 2).setConstant(1.0f / std::sqrt(static_cast<float>(width)));
      h.block(row, at + width / 2, 1, width / 2).setConstant(-1.0f / std::sqrt(static_cast<float>(width)));
    }
  return h;
}

/// Real spherical harmonics of bands 0 to 5 at a unit direction. Source: Sloan 2008, "Stupid Spherical Harmonics (SH)
/// Tricks", Appendix A1 (associated Legendre recurrence).
Eigen::VectorXf harmonics_at(const glm::dvec3& d) {
  constexpr int kBands = 6;
  Eigen::VectorXf y(kBands * kBands);
  const double phi = std::atan2(d.y, d.x);
  for (int l = 0; l < kBands; ++l)
    for (int m = 0; m <= l; ++m) {
      double ratio = 1.0;  // (l - m)! / (l + m)!
      for (int k = l - m + 1; k <= l + m; ++k) ratio /= k;
      const double scale = std::sqrt((2 * l + 1) / (4.0 * std::numbers::pi) * ratio) * (m > 0 ? std::sqrt(2.0) : 1.0);
      const double legendre = std::assoc_legendre(static_cast<unsigned>(l), static_cast<unsigned>(m), d.z);
      y[l * (l + 1) + m] = static_cast<float>(scale * legendre * std::cos(m * phi));
      if (m > 0) y[l * (l + 1) - m] = static_cast<float>(scale * legendre * std::sin(m * phi));
    }
  return y;
}

}  // namespace

LightTransport::LightTransport(const LightResponse& response, const Lumisphere& lumisphere, LightBasis basis,
                               double error)
    : basis_(basis), error_(error) {
  const int bins = lumisphere.count();
  if (basis == LightBasis::bins) {
    response_ = response.channels;
    return;
  }
  Eigen::MatrixXf back;  // [bin][coefficient]: what a unit coefficient puts into the bins
  if (basis == LightBasis::haar) {
    const int side = lumisphere.side();
    const Eigen::MatrixXf h = haar_matrix(side);
    // What is below the horizon continues the rim, so that a constant light is one coefficient.
    project_ = Eigen::MatrixXf::Zero(side * side, bins);
    back.resize(bins, side * side);
    for (int y = 0; y < side; ++y)
      for (int x = 0; x < side; ++x) {
        const int shows = lumisphere.bin_near_cell(x, y), own = lumisphere.bin_of_cell(y * side + x);
        for (int i = 0; i < side; ++i)
          for (int j = 0; j < side; ++j) {
            const float v = h(i, y) * h(j, x);
            project_(i * side + j, shows) += v;
            if (own >= 0) back(own, i * side + j) = v;
          }
      }
  } else {
    constexpr int kSamples = 8;
    project_ = Eigen::MatrixXf::Zero(36, bins);
    back = Eigen::MatrixXf::Zero(bins, 36);
    for (int k = 0; k < bins; ++k) {
      double weights = 0.0, areas = 0.0;
      for (int i = 0; i < kSamples * kSamples; ++i) {
        const Lumisphere::Sample s =
            lumisphere.draw(k, (glm::vec2(i % kSamples, i / kSamples) + 0.5f) / static_cast<float>(kSamples));
        if (s.weight == 0.0f) continue;
        const Eigen::VectorXf y = harmonics_at(glm::dvec3(s.direction));
        project_.col(k) += y / s.density;
        back.row(k) += s.weight * y.transpose();
        weights += static_cast<double>(s.weight);
        areas += 1.0 / static_cast<double>(s.density);
      }
      project_.col(k) *= static_cast<float>(lumisphere.solid_angle(k) / areas);
      back.row(k) /= static_cast<float>(weights);
    }
  }
  norms_ = Eigen::VectorXf::Zero(project_.rows());
  for (std::size_t c = 0; c < 3; ++c) {
    response_[c] = times(response.channels[c], back);
    norms_ += response_[c].colwise().squaredNorm().transpose();
  }
  norms_ = norms_.cwiseSqrt();
  mean_of_bins_.resize(bins);
  for (int k = 0; k < bins; ++k) mean_of_bins_[k] = static_cast<float>(lumisphere.projected(k) / std::numbers::pi);
  mean_of_coefficients_ = back.transpose() * mean_of_bins_;
  for (std::size_t c = 0; c < 3; ++c) albedo_[c] = response.channels[c].rowwise().sum();
}

std::size_t LightTransport::apply(const std::array<Eigen::MatrixXf, 3>& incident,
                                  std::array<Eigen::MatrixXf, 3>* out) const {
  if (basis_ == LightBasis::haar) return apply_haar(incident, out);
  for (std::size_t c = 0; c < 3; ++c) {
    if (basis_ == LightBasis::bins)
      (*out)[c] += times(response_[c], incident[c]);
    else
      (*out)[c] += times(response_[c], times(project_, incident[c]));
  }
  return static_cast<std::size_t>(incident[0].cols() * response_[0].cols());
}

std::size_t LightTransport::apply_haar(const std::array<Eigen::MatrixXf, 3>& incident,
                                       std::array<Eigen::MatrixXf, 3>* out) const {
  std::array<Eigen::MatrixXf, 3> light;
  for (std::size_t c = 0; c < 3; ++c) light[c] = times(project_, incident[c]);
  const auto count = static_cast<std::size_t>(project_.rows());
  std::vector<std::uint32_t> order(count);
  std::vector<float> worth(count);
  std::size_t used = 0;
  for (Eigen::Index t = 0; t < incident[0].cols(); ++t) {
    double all = 0.0;
    for (std::size_t k = 0; k < count; ++k) {
      const auto i = static_cast<Eigen::Index>(k);
      worth[k] = (light[0](i, t) * light[0](i, t) + light[1](i, t) * light[1](i, t) + light[2](i, t) * light[2](i, t)) *
                 norms_[i] * norms_[i];
      all += static_cast<double>(worth[k]);
    }
    std::iota(order.begin(), order.end(), 0u);
    std::sort(order.begin(), order.end(),
              [&](std::uint32_t a, std::uint32_t b) { return worth[a] != worth[b] ? worth[a] > worth[b] : a < b; });
    double rest = all;
    std::array<float, 3> left{};  // of the mean
    for (std::size_t c = 0; c < 3; ++c) left[c] = mean_of_bins_.dot(incident[c].col(t));
    for (const std::uint32_t k : order) {
      if (!(rest > error_ * error_ * all)) break;
      rest -= static_cast<double>(worth[k]);
      for (std::size_t c = 0; c < 3; ++c) {
        const float value = light[c](static_cast<Eigen::Index>(k), t);
        (*out)[c].col(t) += response_[c].col(k) * value;
        left[c] -= mean_of_coefficients_[k] * value;
      }
      ++used;
    }
    for (std::size_t c = 0; c < 3; ++c) (*out)[c].col(t) += albedo_[c] * left[c];
  }
  return used;
}

void require_light_field_material(const Material& m) {
  if (const std::string fault = check_light_field_material(m); !fault.empty())
    throw Error(
        "material " + m.name, "a surface light field cannot hold it: " + fault,
        "leave its parts out (slf.parts), shade them by another mode (--mode-of), or give them another material "
        "(--material)");
}

std::string check_light_field_material(const Material& m) {
  if (m.normal_texture || m.clearcoat_normal_texture) return "its normal map turns the frame within a texel";
  if (m.anisotropy > 0.0f && m.measured.empty()) return "it is anisotropic";
  if (m.unlit) return "it is unlit";
  return {};
}

void GroupShader::shade_each(const PathScene& scene, const LightFieldAtlas& atlas, const TexelGroup& group,
                             const std::atomic<bool>& cancel) {
  const std::vector<std::uint32_t> traced_of = traced_triangles(scene);
  constexpr int kSamples = 2;
  const Eigen::MatrixXf light = spline_.from_means(kSamples);
  parallel_for(std::size_t{0}, group.texels.size(), [&](std::size_t i) {
    if (cancel) return;
    const std::uint32_t t = group.texels[i];
    const SurfacePoint p = point_of_texel(scene, atlas, t, traced_of, options_.texel_m);
    const LightResponse response = compute_response_of_coefficients(p, spline_, kSamples);
    Batch batch = gather(incident_, std::span(&t, 1));
    for (std::size_t c = 0; c < 3; ++c) {
      batch.out[c] = times(spline_.interpolate(), times(response.channels[c], times(light, batch.in[c])));
      for (Eigen::Index bin = 0; bin < incident_.bins; ++bin)
        out_.radiance(3 * bin + static_cast<Eigen::Index>(c), t) = batch.out[c](bin, 0);
    }
  });
  coefficients_ += group.texels.size() * static_cast<std::size_t>(incident_.bins);
}

void GroupShader::shade_btf(const PathScene& scene, const LightFieldAtlas& atlas, const TexelGroup& group,
                            const std::atomic<bool>& cancel) {
  const BtfTexels places = place_btf_texels(scene, atlas, group.texels, options_.texel_m);
  const std::size_t count = group.texels.size();
  std::map<BtfTurn, std::vector<std::size_t>> alike;
  for (std::size_t i = 0; i < count; ++i) alike[places.turns[i]].push_back(i);
  const std::vector<std::pair<BtfTurn, std::vector<std::size_t>>> sets(alike.begin(), alike.end());
  parallel_for(std::size_t{0}, sets.size(), [&](std::size_t k) {
    if (cancel) return;
    const BtfResponse response(*group.point.material->btf, spline_, sets[k].first);
    const std::vector<std::size_t>& members = sets[k].second;
    const std::size_t batches = (members.size() + kBatch - 1) / kBatch;
    parallel_for(std::size_t{0}, batches, [&](std::size_t b) {
      if (cancel) return;
      std::vector<std::uint32_t> texels;
      std::vector<BtfLookup> at;
      std::vector<glm::vec3> scales;
      for (std::size_t i = b * kBatch; i < std::min(members.size(), (b + 1) * kBatch); ++i) {
        texels.push_back(group.texels[members[i]]);
        at.push_back(places.lookups[members[i]]);
        scales.push_back(group.scales[members[i]]);
      }
      Batch batch = gather(incident_, texels);
      response.apply(at, batch.in, &batch.out);
      for (std::size_t i = 0; i < texels.size(); ++i)
        for (std::size_t c = 0; c < 3; ++c)
          batch.out[c].col(static_cast<Eigen::Index>(i)) *= scales[i][static_cast<int>(c)];
      put(batch, texels);
    });
  });
  coefficients_ += count * static_cast<std::size_t>(incident_.bins);
}

std::shared_ptr<const OutgoingField> compute_outgoing(const PathScene& scene, const LightFieldAtlas& atlas,
                                                      const IncidentField& incident, const OutgoingOptions& options,
                                                      const std::atomic<bool>& cancel) {
  auto out = std::make_shared<OutgoingField>();
  const DirectionSpline spline{Lumisphere(incident.side)};
  out->radiance = Eigen::MatrixXf::Zero(3 * incident.bins, static_cast<Eigen::Index>(atlas.texels.size()));
  GroupShader shader(incident, spline, options, out.get());
  for (const TexelGroup& group : group_texels(scene, atlas, options.texel_m)) {
    if (cancel) return nullptr;
    if (group.kind == TexelGroup::Kind::btf)
      shader.shade_btf(scene, atlas, group, cancel);
    else if (group.kind == TexelGroup::Kind::each)
      shader.shade_each(scene, atlas, group, cancel);
    else
      shader.shade(group, cancel);
  }
  if (cancel) return nullptr;
  out->coefficients =
      static_cast<double>(shader.coefficients()) / std::max<double>(static_cast<double>(atlas.texels.size()), 1.0);
  return out;
}

Eigen::VectorXf outgoing_measure(const Lumisphere& lumisphere) {
  Eigen::VectorXf measure(3 * lumisphere.count());
  for (int b = 0; b < lumisphere.count(); ++b)
    measure.segment(3 * b, 3).setConstant(static_cast<float>(lumisphere.solid_angle(b)));
  return measure;
}

double field_error(const Eigen::MatrixXf& field, const Eigen::MatrixXf& truth, const Eigen::VectorXf& measure) {
  double squares = 0.0, sum = 0.0;
  const Eigen::VectorXd weights = measure.cast<double>();
  for (Eigen::Index t = 0; t < truth.cols(); ++t) {
    squares += weights.dot((field.col(t) - truth.col(t)).cast<double>().cwiseAbs2());
    sum += weights.dot(truth.col(t).cast<double>());
  }
  const double all = weights.sum() * static_cast<double>(truth.cols());
  return sum > 0.0 ? std::sqrt(squares / all) / (sum / all) : 0.0;
}

}  // namespace maquette
