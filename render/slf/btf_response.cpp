#include "render/slf/btf_response.h"

#include <cmath>
#include <map>
#include <numbers>

#include "scenes/linear_algebra.h"

namespace maquette {

namespace {

constexpr int kSamples = 4;  ///< squared, of a bin

/// [light][bin]: what each light of a mesh has of the bins' light, times the cosine, sr.
Eigen::MatrixXf light_of_bins(const DirectionMesh& lights, const DirectionSpline& spline, const BtfTurn& turn) {
  const Lumisphere& lumisphere = spline.lumisphere();
  Eigen::MatrixXf sums = Eigen::MatrixXf::Zero(static_cast<Eigen::Index>(lights.size()), lumisphere.count());
  for (int k = 0; k < lumisphere.count(); ++k)
    for (const DirectionSpline::BinSample& s : spline.bin_samples(k, kSamples)) {
      const DirectionWeights near = lights.find(turn.to_btf(s.direction));
      const float weight = s.weight * static_cast<float>(lumisphere.projected(k));
      for (const DirectionSpline::Share& share : spline.shares(s.direction))
        for (int i = 0; i < 3; ++i)
          sums(near.index[static_cast<std::size_t>(i)], share.bin) += weight * share.weight * near.weight[i];
    }
  return sums * spline.from_means(kSamples);
}

}  // namespace

glm::vec3 BtfTurn::to_btf(const glm::vec3& d) const {
  const double angle = 2.0 * std::numbers::pi * step / kSteps;
  const auto c = static_cast<float>(std::cos(angle)), s = static_cast<float>(std::sin(angle));
  const float along = c * d.x + s * d.y, up = c * d.y - s * d.x;
  return {along, mirrored ? -up : up, d.z};
}

glm::vec3 BtfTurn::from_btf(const glm::vec3& d) const {
  const double angle = 2.0 * std::numbers::pi * step / kSteps;
  const auto c = static_cast<float>(std::cos(angle)), s = static_cast<float>(std::sin(angle));
  const float up = mirrored ? -d.y : d.y;
  return {c * d.x - s * up, s * d.x + c * up, d.z};
}

BtfTurn btf_turn(const glm::vec2& t, const glm::vec2& b) {
  const double angle = std::atan2(static_cast<double>(t.y), static_cast<double>(t.x));
  const int step = static_cast<int>(std::lround(angle / (2.0 * std::numbers::pi) * BtfTurn::kSteps));
  return {(step + BtfTurn::kSteps) % BtfTurn::kSteps, t.x * b.y - t.y * b.x < 0.0f};
}

BtfResponse::BtfResponse(const Btf& btf, const DirectionSpline& spline, const BtfTurn& turn) : btf_(btf) {
  const auto terms = static_cast<Eigen::Index>(btf.components) + 1, views = static_cast<Eigen::Index>(btf.views.size());
  light_.resize(views * terms, spline.lumisphere().count());
  std::map<const DirectionMesh*, Eigen::MatrixXf> of_mesh;
  for (Eigen::Index v = 0; v < views; ++v) {
    const BtfView& view = btf.views[static_cast<std::size_t>(v)];
    Eigen::MatrixXf& light = of_mesh[view.lights.get()];
    if (light.size() == 0) light = light_of_bins(*view.lights, spline, turn);
    const Eigen::Map<const Eigen::MatrixXf> weights(view.light_weights.data(), btf.components, light.rows());
    light_.row(v * terms) = light.colwise().sum();
    if (btf.components > 0) light_.middleRows(v * terms + 1, btf.components) = times(weights, light);
  }
  Eigen::MatrixXf shares = Eigen::MatrixXf::Zero(static_cast<Eigen::Index>(spline.views().size()), views);
  for (Eigen::Index i = 0; i < shares.rows(); ++i) {
    const DirectionWeights near = btf.view_mesh.find(turn.to_btf(spline.views()[static_cast<std::size_t>(i)]));
    for (int k = 0; k < 3; ++k) shares(i, near.index[static_cast<std::size_t>(k)]) += near.weight[k];
  }
  views_ = times(spline.fit(), shares);
}

void BtfResponse::apply(std::span<const BtfLookup> at, const std::array<Eigen::MatrixXf, 3>& incident,
                        std::array<Eigen::MatrixXf, 3>* out) const {
  const auto terms = static_cast<std::size_t>(btf_.components) + 1, views = btf_.views.size();
  const auto texels = static_cast<Eigen::Index>(at.size());
  std::array<Eigen::MatrixXf, 3> light, seen;
  for (std::size_t c = 0; c < 3; ++c) {
    light[c] = times(light_, incident[c]);
    seen[c].resize(static_cast<Eigen::Index>(views), texels);
  }
  std::vector<glm::vec3> factors(terms);
  for (Eigen::Index i = 0; i < texels; ++i)
    for (std::size_t v = 0; v < views; ++v) {
      read_btf_factors(btf_, btf_.views[v], at[static_cast<std::size_t>(i)], factors.data());
      const auto row = static_cast<Eigen::Index>(v * terms);
      glm::vec3 sum(0.0f);
      for (std::size_t k = 0; k < terms; ++k) {
        const auto r = row + static_cast<Eigen::Index>(k);
        sum += factors[k] * glm::vec3(light[0](r, i), light[1](r, i), light[2](r, i));
      }
      for (std::size_t c = 0; c < 3; ++c) seen[c](static_cast<Eigen::Index>(v), i) = sum[static_cast<int>(c)];
    }
  for (std::size_t c = 0; c < 3; ++c) (*out)[c] = times(views_, seen[c]);
}

Eigen::VectorXf BtfResponse::apply_factors(const Eigen::VectorXf& factors, Eigen::Index channel,
                                           const Eigen::VectorXf& light) const {
  const Eigen::Index views = views_.cols(), terms = light_.rows() / views;
  Eigen::VectorXf seen = Eigen::VectorXf::Zero(views);
  for (Eigen::Index v = 0; v < views; ++v)
    for (Eigen::Index k = v * terms; k < (v + 1) * terms; ++k) seen[v] += factors[3 * k + channel] * light[k];
  return views_ * seen;
}

}  // namespace maquette
