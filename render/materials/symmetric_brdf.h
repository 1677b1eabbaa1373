#pragma once

#include <algorithm>
#include <cmath>
#include <glm/glm.hpp>
#include <vector>

#include "render/math/shared_formulas.h"
#include "scenes/brdf.h"
#include "scenes/luminance.h"

namespace maquette {

inline constexpr int kHalfPhiD = kPhiDCount / 2;
inline constexpr double kHalfPi = 1.57079632679489661923;

/// A table averaged with its mirror image (phi_d and pi - phi_d): half the entries, enough for integrals over both
/// sides of the plane of incidence. Internal to the derivation of tables.
struct SymmetricBrdf {
  std::vector<glm::vec3> rgb;    ///< [theta_h 90][theta_d 90][phi_d 90], phi_d in [0, pi/2]
  std::vector<float> luminance;  ///< same layout, Rec.709 Y

  explicit SymmetricBrdf(const BrdfTable& table);

  /// Trilinear, `x` and `y` in continuous bins (centres at integers, clamped), phi_d in [0, pi/2].
  template <typename Value>
  static Value interpolate(const std::vector<Value>& values, float x, float y, float phi_d_rad) {
    const float cx = std::clamp(x, 0.0f, kThetaHCount - 1.0f);
    const float cy = std::clamp(y, 0.0f, kThetaDCount - 1.0f);
    const float cz = std::clamp(phi_d_rad * 57.29577951f - 0.5f, 0.0f, kHalfPhiD - 1.0f);
    const int ix = std::min(static_cast<int>(cx), kThetaHCount - 2);
    const int iy = std::min(static_cast<int>(cy), kThetaDCount - 2);
    const int iz = std::min(static_cast<int>(cz), kHalfPhiD - 2);
    const float fx = cx - static_cast<float>(ix), fy = cy - static_cast<float>(iy), fz = cz - static_cast<float>(iz);
    const Value* p = values.data() + (ix * kThetaDCount + iy) * kHalfPhiD + iz;
    constexpr int kRow = kHalfPhiD, kSlice = kThetaDCount * kHalfPhiD;
    const auto along_phi = [&](const Value* q) { return q[0] * (1.0f - fz) + q[1] * fz; };
    const auto along_d = [&](const Value* q) { return along_phi(q) * (1.0f - fy) + along_phi(q + kRow) * fy; };
    return along_d(p) * (1.0f - fx) + along_d(p + kSlice) * fx;
  }
};

/// theta_h of a position in bins from the table's edge (0..90), inverting the square-root spacing.
inline double theta_h_of_bin_edge(double x) { return (x / kThetaHCount) * (x / kThetaHCount) * kHalfPi; }

/// The view direction at theta_o relative to a half vector (theta_h, phi_h from the view plane).
struct HalfVectorView {
  double projection;  ///< wo . h
  double cos_i;       ///< of the mirrored direction; negative below the horizon
  float theta_d_bin;  ///< where the projection is positive
  float phi_d_rad;    ///< folded into [0, pi/2]
};
inline HalfVectorView view_of_half_vector(double sin_h, double cos_h, double sin_phi, double cos_phi, double sin_o,
                                          double cos_o) {
  // wo in the frame of h: its azimuth is that of the light rotated by pi, which is the same after folding.
  const double x = std::abs(sin_o * cos_h * cos_phi - cos_o * sin_h);
  const double y = sin_o * std::abs(sin_phi);
  HalfVectorView view;
  view.projection = sin_o * sin_h * cos_phi + cos_o * cos_h;
  view.cos_i = 2.0 * view.projection * cos_h - cos_o;
  const auto fx = static_cast<float>(x), fy = static_cast<float>(y);
  const auto ahead = static_cast<float>(std::max(view.projection, 0.0));
  view.theta_d_bin =
      shared::merl_atan(std::sqrt(fx * fx + fy * fy), ahead) * static_cast<float>(kThetaDCount / kHalfPi) - 0.5f;
  view.phi_d_rad = shared::merl_atan(fy, fx);
  return view;
}

/// Largest theta_h whose mirrored direction can be above the horizon for a view at theta_o.
inline double largest_theta_h(double theta_o) { return 0.5 * (kHalfPi + theta_o); }

/// Largest phi_h (from the view plane) that keeps the mirrored direction above the horizon; 0 if none does, pi if all
/// do.
double largest_phi_h(double theta_h, double theta_o);

/// Row of BrdfTables::theta_cells and phi_cells for all elevations. Cost: about 0.5 M evaluations, parallel.
struct BrdfTables;
void compute_importance(const SymmetricBrdf& brdf, BrdfTables& tables);
/// BrdfTables::albedo by Gauss-Legendre quadrature between the table's knots.
void compute_albedo(const SymmetricBrdf& brdf, BrdfTables& tables);

}  // namespace maquette
