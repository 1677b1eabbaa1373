#include "render/slf/direction_spline.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "render/slf/parabolic.h"
#include "scenes/linear_algebra.h"

namespace maquette {

namespace {

/// Of the equation that a coefficient is the value at its bin, among those that determine it: what little of a bin is
/// above the horizon may not decide.
constexpr double kHold = 1e-3;
constexpr int kViewsASide = 2;  ///< of a cell
constexpr float kRim = 0.995f;  ///< of the disc's radius: beyond it BRDFs end

/// Weights of the cells before, at and after a point, `t` cells from the middle's centre.
glm::vec3 spline_weights(float t) {
  const float low = 0.5f - t, high = 0.5f + t;
  return {0.5f * low * low, 0.75f - t * t, 0.5f * high * high};
}

/// Solves (B^T W B + h) c = (B^T W + h E) f for each unit f, with the trace of the former as unit of `h`.
Eigen::MatrixXf solve(const Eigen::MatrixXd& b, const Eigen::VectorXd& weights, const Eigen::MatrixXd& held) {
  Eigen::MatrixXd right = b.transpose() * weights.asDiagonal(), normal = times(right, b);
  const double hold = kHold * normal.trace() / static_cast<double>(normal.rows());
  normal.diagonal().array() += hold;
  right += hold * held;
  return Eigen::LDLT<Eigen::MatrixXd>(normal).solve(right).cast<float>();
}

}  // namespace

DirectionSpline::DirectionSpline(const Lumisphere& lumisphere) : lumisphere_(lumisphere) {
  const int bins = lumisphere.count(), side = lumisphere.side(), fine = side * kViewsASide;
  std::vector<double> areas;
  for (int k = 0; k < bins; ++k) {
    views_.push_back(lumisphere.direction(k));
    areas.push_back(0.0);
  }
  const auto jacobian = [](float r2) {
    return 4.0 / ((1.0 + static_cast<double>(r2)) * (1.0 + static_cast<double>(r2)));
  };
  for (int y = 0; y < fine; ++y)
    for (int x = 0; x < fine; ++x) {
      const glm::vec2 p = (glm::vec2(x, y) + 0.5f) * (2.0f / static_cast<float>(fine)) - 1.0f;
      if (glm::length(p) > kRim) continue;
      views_.push_back(glm::normalize(shared::direction_from_parabolic(p)));
      areas.push_back(jacobian(glm::dot(p, p)));
    }
  const auto count = static_cast<Eigen::Index>(views_.size());
  const Eigen::MatrixXd held = Eigen::MatrixXd::Identity(bins, count);
  fit_ = solve(values_at(views_), Eigen::Map<const Eigen::VectorXd>(areas.data(), count), held);
  const std::vector<glm::vec3> own(views_.begin(), views_.begin() + bins);
  interpolate_ = solve(values_at(own), Eigen::VectorXd::Ones(bins), Eigen::MatrixXd::Identity(bins, bins));
}

std::array<DirectionSpline::Share, 9> DirectionSpline::shares(const glm::vec3& direction) const {
  const auto side = static_cast<float>(lumisphere_.side());
  return shares_at(lumisphere_, (shared::parabolic_from_direction(direction) * 0.5f + 0.5f) * side);
}

std::array<DirectionSpline::Share, 9> DirectionSpline::shares_at(const Lumisphere& lumisphere, const glm::vec2& cells,
                                                                 float step) {
  const int side = lumisphere.side();
  const glm::ivec2 cell = glm::clamp(glm::ivec2(glm::floor(cells)), 0, side - 1);
  const glm::vec2 t = cells - glm::vec2(cell) - 0.5f;
  const glm::vec3 excess = step * step / 12.0f * glm::vec3(1.0f, -2.0f, 1.0f);
  const glm::vec3 wx = spline_weights(t.x) - excess, wy = spline_weights(t.y) - excess;
  std::array<Share, 9> shares;
  for (int i = 0; i < 9; ++i)
    shares[static_cast<std::size_t>(i)] = {lumisphere.bin_near_cell(cell.x + i % 3 - 1, cell.y + i / 3 - 1),
                                           wx[i % 3] * wy[i / 3]};
  return shares;
}

float DirectionSpline::value(const Eigen::VectorXf& coefficients, const glm::vec3& direction) const {
  float sum = 0.0f;
  for (const Share& s : shares(direction)) sum += s.weight * coefficients[s.bin];
  return sum;
}

Eigen::MatrixXd DirectionSpline::values_at(const std::vector<glm::vec3>& directions) const {
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(directions.size()), lumisphere_.count());
  for (std::size_t i = 0; i < directions.size(); ++i)
    for (const Share& s : shares(directions[i]))
      values(static_cast<Eigen::Index>(i), s.bin) += static_cast<double>(s.weight);
  return values;
}

std::vector<DirectionSpline::BinSample> DirectionSpline::bin_samples(int bin, int samples) const {
  std::vector<BinSample> all;
  float sum = 0.0f;
  for (int i = 0; i < samples * samples; ++i) {
    const glm::vec2 uv = (glm::vec2(i % samples, i / samples) + 0.5f) / static_cast<float>(samples);
    const BinSample s = lumisphere_.draw(bin, uv);
    if (!(s.weight > 0.0f)) continue;
    all.push_back(s);
    sum += s.weight;
  }
  for (BinSample& s : all) s.weight /= sum;
  return all;
}

const Eigen::MatrixXf& DirectionSpline::from_means(int samples) const {
  const std::lock_guard lock(solved_->mutex);
  Eigen::MatrixXf& solved = solved_->of_samples[samples];
  if (solved.size() == 0) solved = solve_means(samples);
  return solved;
}

Eigen::MatrixXf DirectionSpline::solve_means(int samples) const {
  const int bins = lumisphere_.count();
  Eigen::MatrixXd means = Eigen::MatrixXd::Zero(bins, bins);
  for (int k = 0; k < bins; ++k)
    for (const BinSample& s : bin_samples(k, samples))
      for (const Share& share : shares(s.direction))
        means(k, share.bin) += static_cast<double>(s.weight * share.weight);
  return solve(means, Eigen::VectorXd::Ones(bins), Eigen::MatrixXd::Identity(bins, bins));
}

}  // namespace maquette
