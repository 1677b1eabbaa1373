
#include "render/materials/brdf_tables.h"
#include "render/materials/symmetric_brdf.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

// Gauss-Legendre, three points on [-1, 1].
constexpr double kNodes[3] = {-0.774596669241483377, 0.0, 0.774596669241483377};
constexpr double kWeights[3] = {5.0 / 9.0, 8.0 / 9.0, 5.0 / 9.0};
constexpr int kPhiPoints = 32;

/// Integral over phi_h in [0, phi_max] of f cos(theta_i) 4 (wo . h), both sides.
glm::dvec3 integrate_phi(const SymmetricBrdf& brdf, double x, double theta_o) {
  const double theta_h = theta_h_of_bin_edge(x);
  const double phi_max = largest_phi_h(theta_h, theta_o);
  const double sin_h = std::sin(theta_h), cos_h = std::cos(theta_h), sin_o = std::sin(theta_o),
               cos_o = std::cos(theta_o);
  const double step = phi_max / kPhiPoints;
  const double sin_step = std::sin(step), cos_step = std::cos(step);
  double sin_phi = std::sin(0.5 * step), cos_phi = std::cos(0.5 * step);
  glm::dvec3 sum(0.0);
  for (int j = 0; j < kPhiPoints; ++j) {
    const HalfVectorView view = view_of_half_vector(sin_h, cos_h, sin_phi, cos_phi, sin_o, cos_o);
    if (view.projection > 0.0 && view.cos_i > 0.0) {
      const glm::vec3 f =
          SymmetricBrdf::interpolate(brdf.rgb, static_cast<float>(x - 0.5), view.theta_d_bin, view.phi_d_rad);
      sum += glm::dvec3(f) * (view.cos_i * 4.0 * view.projection);
    }
    const double next_sin = sin_phi * cos_step + cos_phi * sin_step;
    cos_phi = cos_phi * cos_step - sin_phi * sin_step;
    sin_phi = next_sin;
  }
  return sum * (2.0 * step);
}

glm::dvec3 albedo_at(const SymmetricBrdf& brdf, double theta_o) {
  const auto bin_of = [](double theta) { return kThetaHCount * std::sqrt(theta / kHalfPi); };
  const double end = std::min(bin_of(largest_theta_h(theta_o)), static_cast<double>(kThetaHCount));
  // Beyond this bin part of the phi circle is below the horizon: the integrand has a kink, so a knot is placed there.
  const double kink = bin_of(0.5 * (kHalfPi - theta_o));
  std::vector<double> knots = {0.0, kink, end};
  for (int i = 0; i < kThetaHCount; ++i) {
    if (i + 0.5 < end) knots.push_back(i + 0.5);
  }
  std::sort(knots.begin(), knots.end());
  glm::dvec3 sum(0.0);
  for (std::size_t i = 0; i + 1 < knots.size(); ++i) {
    const double half_width = 0.5 * (knots[i + 1] - knots[i]), middle = 0.5 * (knots[i + 1] + knots[i]);
    if (half_width <= 0.0) continue;
    for (int q = 0; q < 3; ++q) {
      const double x = middle + half_width * kNodes[q];
      const double theta_h = theta_h_of_bin_edge(x);
      const double theta_per_bin = 2.0 * x / (double{kThetaHCount} * kThetaHCount) * kHalfPi;
      sum += integrate_phi(brdf, x, theta_o) * (std::sin(theta_h) * theta_per_bin * half_width * kWeights[q]);
    }
  }
  return sum;
}

}  // namespace

void compute_albedo(const SymmetricBrdf& brdf, BrdfTables& tables) {
  tables.albedo.resize(kAlbedoCount);
  parallel_for(0, kAlbedoCount, [&](int i) {
    // The limit at the horizon is evaluated just above it.
    const double theta_o = std::min(i * kHalfPi / (kAlbedoCount - 1), kHalfPi - 1e-3);
    tables.albedo[static_cast<std::size_t>(i)] = glm::vec3(albedo_at(brdf, theta_o));
  });
}

}  // namespace maquette
