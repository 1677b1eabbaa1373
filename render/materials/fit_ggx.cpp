
#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <numbers>
#include <span>

#include "render/materials/brdf_tables.h"
#include "render/materials/fit_samples.h"
#include "render/materials/symmetric_brdf.h"
#include "scenes/files.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr int kGgxVersion = 1;
constexpr const char* kGgxKind = "ggx-fit";
constexpr double kMinAlpha = 0.003;
constexpr int kAlphaCount = 16;

/// The model is linear in diffuse albedo and F0: f = diffuse / pi + f0 * specular + grazing.
struct Basis {
  double specular, grazing;
};

/// GGX with uncorrelated Smith masking (Walter et al. 2007, Eq. 33, 34) and Schlick's Fresnel term (1994).
std::vector<Basis> make_basis(const std::vector<FitSample>& samples, double alpha) {
  const double a2 = alpha * alpha;
  std::vector<Basis> basis;
  basis.reserve(samples.size());
  for (const FitSample& s : samples) {
    const double c2 = s.cos_h * s.cos_h, t = c2 * a2 + (1.0 - c2);
    const auto masking = [&](double c) { return 1.0 / (c + std::sqrt(a2 + (1.0 - a2) * c * c)); };
    const double lobe = a2 / (std::numbers::pi * t * t) * masking(s.cos_i) * masking(s.cos_o);
    const double schlick = std::pow(1.0 - s.cos_d, 5.0);
    basis.push_back({lobe * (1.0 - schlick), lobe * schlick});
  }
  return basis;
}

struct Channel {
  double diffuse = 0.0, f0 = 0.04, error = 0.0;
};

/// Gauss-Newton with halved steps on the two parameters, kept within [0, 1].
Channel fit_channel(const std::vector<FitSample>& samples, const std::vector<Basis>& basis, int channel) {
  const auto error_of = [&](double diffuse, double f0) {
    double sum = 0.0;
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double root = std::cbrt(diffuse / std::numbers::pi + f0 * basis[i].specular + basis[i].grazing);
      sum += samples[i].weight * (root - samples[i].root[channel]) * (root - samples[i].root[channel]);
    }
    return sum;
  };
  Channel fit;
  fit.diffuse = 0.2;
  fit.error = error_of(fit.diffuse, fit.f0);
  for (int iteration = 0; iteration < 12; ++iteration) {
    double jj[3] = {}, jr[2] = {};
    for (std::size_t i = 0; i < samples.size(); ++i) {
      const double root =
          std::cbrt(std::max(fit.diffuse / std::numbers::pi + fit.f0 * basis[i].specular + basis[i].grazing, 1e-9));
      const double slope = 1.0 / (3.0 * root * root), residual = samples[i].root[channel] - root;
      const double a = slope / std::numbers::pi, b = slope * basis[i].specular, w = samples[i].weight;
      jj[0] += w * a * a;
      jj[1] += w * a * b;
      jj[2] += w * b * b;
      jr[0] += w * a * residual;
      jr[1] += w * b * residual;
    }
    const double damping = 1e-9 * (jj[0] + jj[2]) + 1e-30;
    const double determinant = (jj[0] + damping) * (jj[2] + damping) - jj[1] * jj[1];
    const double step_d = ((jj[2] + damping) * jr[0] - jj[1] * jr[1]) / determinant;
    const double step_f = ((jj[0] + damping) * jr[1] - jj[1] * jr[0]) / determinant;
    bool better = false;
    for (double scale = 1.0; scale > 1e-2 && !better; scale *= 0.5) {
      const double diffuse = std::clamp(fit.diffuse + scale * step_d, 0.0, 1.0);
      const double f0 = std::clamp(fit.f0 + scale * step_f, 0.0, 1.0);
      const double error = error_of(diffuse, f0);
      if (error < fit.error * (1.0 - 1e-6)) {
        fit = {diffuse, f0, error};
        better = true;
      }
    }
    if (!better) break;
  }
  return fit;
}

using Fit = std::array<Channel, 3>;
Fit fit_alpha(const std::vector<FitSample>& samples, double alpha) {
  const std::vector<Basis> basis = make_basis(samples, alpha);
  return {fit_channel(samples, basis, 0), fit_channel(samples, basis, 1), fit_channel(samples, basis, 2)};
}
double error_of(const Fit& fit) { return fit[0].error + fit[1].error + fit[2].error; }

GgxFit compute_ggx_fit(const BrdfTable& brdf) {
  const std::vector<FitSample> samples = fit_samples(brdf);
  const double ratio = std::log(1.0 / kMinAlpha) / (kAlphaCount - 1);
  std::vector<double> alphas;
  for (int i = 0; i < kAlphaCount; ++i) alphas.push_back(kMinAlpha * std::exp(i * ratio));
  std::vector<Fit> fits(alphas.size());
  const auto run = [&](std::size_t begin) {
    fits.resize(alphas.size());
    parallel_for(begin, alphas.size(), [&](std::size_t i) { fits[i] = fit_alpha(samples, alphas[i]); });
  };
  const auto best = [&] {
    std::size_t b = 0;
    for (std::size_t i = 1; i < fits.size(); ++i) b = error_of(fits[i]) < error_of(fits[b]) ? i : b;
    return b;
  };
  run(0);
  // Then pairs around the best one, with decreasing steps.
  for (double step = 0.5 * ratio; step > 0.03; step *= 0.5) {
    const double centre = alphas[best()];
    const std::size_t begin = alphas.size();
    alphas.push_back(std::max(centre * std::exp(-step), kMinAlpha));
    alphas.push_back(std::min(centre * std::exp(step), 1.0));
    run(begin);
  }
  const std::size_t b = best();
  double energy = 0.0;
  for (const FitSample& s : samples) energy += s.weight * glm::dot(s.root, s.root);
  GgxFit fit;
  fit.alpha = static_cast<float>(alphas[b]);
  for (int c = 0; c < 3; ++c) {
    fit.diffuse[c] = static_cast<float>(fits[b][static_cast<std::size_t>(c)].diffuse);
    fit.specular[c] = static_cast<float>(fits[b][static_cast<std::size_t>(c)].f0);
  }
  fit.relative_error = energy > 0.0 ? static_cast<float>(std::sqrt(error_of(fits[b]) / energy)) : 0.0f;
  return fit;
}

}  // namespace

GgxFit fit_ggx(const BrdfTable& brdf) {
  GgxFit fit;
  if (brdf.hash != 0) {
    const auto bytes = cache_load(kGgxKind, kGgxVersion, brdf.hash);
    if (bytes && bytes->size() == sizeof fit) {
      std::memcpy(static_cast<void*>(&fit), bytes->data(), sizeof fit);
      return fit;
    }
  }
  fit = compute_ggx_fit(brdf);
  if (brdf.hash != 0) cache_store(kGgxKind, kGgxVersion, brdf.hash, std::as_bytes(std::span(&fit, 1)));
  return fit;
}

}  // namespace maquette
