#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <numbers>
#include <span>

#include "render/materials/brdf_tables.h"
#include "render/materials/fit_samples.h"
#include "render/materials/symmetric_brdf.h"
#include "scenes/files.h"

namespace maquette {

namespace {

constexpr int kSgVersion = 1;
constexpr const char* kSgKind = "sg-fit";
constexpr int kLobes = 3;
constexpr int kParameters = 1 + 2 * kLobes;
using Vector = Eigen::Matrix<double, kParameters, 1>;
using Matrix = Eigen::Matrix<double, kParameters, kParameters>;

/// The model depends on theta_h alone, so the least squares over all bins equal those over the weighted mean of each
/// theta_h.
struct Profile {
  std::array<double, kThetaHCount> one_minus_cos = {}, weight = {}, root = {};
  double scatter = 0.0;  ///< squared distance of the bins from these means: a lower bound of the error
  double energy = 0.0;
};

Profile make_profile(const std::vector<FitSample>& samples, int channel) {
  Profile profile;
  for (const FitSample& s : samples) {
    const auto h = static_cast<std::size_t>(s.theta_h_bin);
    profile.weight[h] += s.weight;
    profile.root[h] += s.weight * s.root[channel];
    profile.energy += s.weight * s.root[channel] * s.root[channel];
  }
  for (std::size_t h = 0; h < kThetaHCount; ++h) {
    const double half = 0.5 * theta_h_of_bin_edge(static_cast<double>(h) + 0.5);
    profile.one_minus_cos[h] = 2.0 * std::sin(half) * std::sin(half);
    if (profile.weight[h] > 0.0) profile.root[h] /= profile.weight[h];
    profile.scatter -= profile.weight[h] * profile.root[h] * profile.root[h];
  }
  profile.scatter = std::max(0.0, profile.scatter + profile.energy);
  return profile;
}

/// Parameters are logarithms, so that all values stay positive: diffuse / pi, then amplitude and sharpness of each
/// lobe.
double residual_squares(const Profile& profile, const Vector& log_parameters, Matrix* jj, Vector* jr) {
  const Vector p = log_parameters.array().exp();
  if (jj) {
    jj->setZero();
    jr->setZero();
  }
  double sum = 0.0;
  for (std::size_t h = 0; h < kThetaHCount; ++h) {
    if (profile.weight[h] <= 0.0) continue;
    Vector gradient;
    gradient[0] = p[0];
    double value = p[0];
    for (int l = 0; l < kLobes; ++l) {
      const double amplitude = p[1 + 2 * l], sharpness = p[2 + 2 * l];
      const double lobe = amplitude * std::exp(-sharpness * profile.one_minus_cos[h]);
      value += lobe;
      gradient[1 + 2 * l] = lobe;
      gradient[2 + 2 * l] = -lobe * sharpness * profile.one_minus_cos[h];
    }
    const double root = std::cbrt(value), residual = profile.root[h] - root;
    sum += profile.weight[h] * residual * residual;
    if (jj) {
      gradient /= 3.0 * root * root;
      jj->noalias() += profile.weight[h] * gradient * gradient.transpose();
      jr->noalias() += profile.weight[h] * residual * gradient;
    }
  }
  return sum;
}

/// Levenberg-Marquardt from one start.
double descend(const Profile& profile, Vector& parameters) {
  double damping = 1e-2;
  double error = residual_squares(profile, parameters, nullptr, nullptr);
  for (int iteration = 0; iteration < 80; ++iteration) {
    Matrix jj;
    Vector jr;
    residual_squares(profile, parameters, &jj, &jr);
    Matrix damped = jj;
    damped.diagonal() += damping * jj.diagonal() + Vector::Constant(1e-12 * (1e-12 + jj.trace()));
    Vector step = damped.ldlt().solve(jr);
    if (!step.allFinite()) break;
    step = step.cwiseMax(-2.0).cwiseMin(2.0);
    Vector tried = parameters + step;
    // Amplitudes from 1e-9 to 1e9 per steradian, sharpness from 0.1 to 1e8: beyond, a lobe is below the first bin.
    for (int l = 0; l < kLobes; ++l) {
      tried[1 + 2 * l] = std::clamp(tried[1 + 2 * l], -20.0, 20.0);
      tried[2 + 2 * l] = std::clamp(tried[2 + 2 * l], -2.3, 18.4);
    }
    tried[0] = std::clamp(tried[0], -20.0, std::log(1.0 / std::numbers::pi));
    const double tried_error = residual_squares(profile, tried, nullptr, nullptr);
    if (tried_error < error) {
      const bool converged = tried_error > error * (1.0 - 1e-7);
      parameters = tried;
      error = tried_error;
      damping = std::max(damping * 0.3, 1e-9);
      if (converged) break;
    } else {
      damping *= 4.0;
      if (damping > 1e8) break;
    }
  }
  return error;
}

SgFit compute_sg_fit(const BrdfTable& brdf) {
  // Starts from very glossy to dull; the best result is kept.
  constexpr double kStarts[][kLobes] = {
      {1e5, 5e3, 1e2}, {1e4, 5e2, 2e1}, {2e3, 1e2, 1e1}, {1e2, 1e1, 2.0}, {2e5, 3e4, 3e3}};
  const std::vector<FitSample> samples = fit_samples(brdf);
  SgFit fit;
  fit.lobes.resize(kLobes);
  double error_sum = 0.0, energy_sum = 0.0;
  for (int channel = 0; channel < 3; ++channel) {
    const Profile profile = make_profile(samples, channel);
    energy_sum += profile.energy;
    if (!(profile.energy > 0.0)) continue;  // black: all zero
    const double peak = std::pow(*std::max_element(profile.root.begin(), profile.root.end()), 3.0);
    const double low = std::max(std::pow(profile.root[70], 3.0), 1e-6 * peak);
    Vector best;
    double best_error = std::numeric_limits<double>::infinity();
    for (const auto& start : kStarts) {
      Vector p;
      p[0] = std::log(std::min(low, 0.9 / std::numbers::pi));
      for (int l = 0; l < kLobes; ++l) {
        p[1 + 2 * l] = std::log(peak) - 2.0 * l;
        p[2 + 2 * l] = std::log(start[l]);
      }
      const double error = descend(profile, p);
      if (error < best_error) {
        best_error = error;
        best = p;
      }
    }
    std::array<int, kLobes> order = {0, 1, 2};
    std::sort(order.begin(), order.end(), [&](int a, int b) { return best[2 + 2 * a] > best[2 + 2 * b]; });
    fit.diffuse[channel] = static_cast<float>(std::numbers::pi * std::exp(best[0]));
    for (std::size_t l = 0; l < kLobes; ++l) {
      fit.lobes[l].amplitude[channel] = static_cast<float>(std::exp(best[1 + 2 * order[l]]));
      fit.lobes[l].sharpness[channel] = static_cast<float>(std::exp(best[2 + 2 * order[l]]));
    }
    error_sum += best_error + profile.scatter;
  }
  fit.relative_error = energy_sum > 0.0 ? static_cast<float>(std::sqrt(error_sum / energy_sum)) : 0.0f;
  return fit;
}

/// Plain data for the cache.
struct StoredFit {
  glm::vec3 diffuse{};
  SgFit::Lobe lobes[kLobes];
  float relative_error;
};

}  // namespace

SgFit fit_sg(const BrdfTable& brdf) {
  if (brdf.hash != 0) {
    const auto bytes = cache_load(kSgKind, kSgVersion, brdf.hash);
    if (bytes && bytes->size() == sizeof(StoredFit)) {
      StoredFit stored;
      std::memcpy(static_cast<void*>(&stored), bytes->data(), sizeof stored);
      return {stored.diffuse, {std::begin(stored.lobes), std::end(stored.lobes)}, stored.relative_error};
    }
  }
  SgFit fit = compute_sg_fit(brdf);
  if (brdf.hash != 0) {
    StoredFit stored{fit.diffuse, {fit.lobes[0], fit.lobes[1], fit.lobes[2]}, fit.relative_error};
    cache_store(kSgKind, kSgVersion, brdf.hash, std::as_bytes(std::span(&stored, 1)));
  }
  return fit;
}

}  // namespace maquette
