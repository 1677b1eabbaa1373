#include "render/materials/symmetric_brdf.h"

#include <numbers>

#include "scenes/parallel.h"

namespace maquette {

SymmetricBrdf::SymmetricBrdf(const BrdfTable& table) {
  constexpr int kRows = kThetaHCount * kThetaDCount;
  rgb.resize(static_cast<std::size_t>(kRows) * kHalfPhiD);
  luminance.resize(rgb.size());
  parallel_for(0, kThetaHCount, [&](int theta_h) {
    for (int row = theta_h * kThetaDCount; row < (theta_h + 1) * kThetaDCount; ++row) {
      const glm::vec3* in = &table.rgb[static_cast<std::size_t>(row) * kPhiDCount];
      const std::size_t out = static_cast<std::size_t>(row) * kHalfPhiD;
      for (std::size_t p = 0; p < kHalfPhiD; ++p) {
        rgb[out + p] = 0.5f * (in[p] + in[kPhiDCount - 1 - p]);
        luminance[out + p] = maquette::luminance(rgb[out + p]);
      }
    }
  });
}

double largest_phi_h(double theta_h, double theta_o) {
  // cos(theta_i) = 2 (wo . h) cos(theta_h) - cos(theta_o) = sin(theta_o) sin(2 theta_h) cos(phi) + cos(theta_o) cos(2
  // theta_h).
  const double a = std::sin(theta_o) * std::sin(2.0 * theta_h);
  const double b = std::cos(theta_o) * std::cos(2.0 * theta_h);
  if (b >= a) return std::numbers::pi;
  if (b <= -a) return 0.0;
  return std::acos(-b / a);
}

}  // namespace maquette
