#include "render/materials/fit_samples.h"

#include <cmath>
#include <numbers>

#include "render/materials/symmetric_brdf.h"

namespace maquette {

std::vector<FitSample> fit_samples(const BrdfTable& brdf) {
  constexpr int kThetaDStep = 9, kPhiStep = 22;
  std::vector<FitSample> samples;
  for (int h = 0; h < kThetaHCount; ++h) {
    const double theta_h = theta_h_of_bin_edge(h + 0.5), sin_h = std::sin(theta_h);
    for (int d = kThetaDStep / 2; d < kThetaDCount; d += kThetaDStep) {
      const double theta_d = (d + 0.5) / kThetaDCount * kHalfPi;
      for (int p = kPhiStep / 2; p < kHalfPhiD; p += kPhiStep) {
        FitSample s;
        s.theta_h_bin = h;
        s.cos_h = std::cos(theta_h);
        s.cos_d = std::cos(theta_d);
        const double across = sin_h * std::sin(theta_d) * std::cos((p + 0.5) / kPhiDCount * std::numbers::pi);
        s.cos_i = s.cos_h * s.cos_d - across;
        s.cos_o = s.cos_h * s.cos_d + across;
        if (s.cos_i <= 0.0 || s.cos_o <= 0.0) continue;
        s.weight = s.cos_i * s.cos_o;
        const std::size_t row = static_cast<std::size_t>(h * kThetaDCount + d) * kPhiDCount;
        const glm::dvec3 value = 0.5 * (glm::dvec3(brdf.rgb[row + static_cast<std::size_t>(p)]) +
                                        glm::dvec3(brdf.rgb[row + static_cast<std::size_t>(kPhiDCount - 1 - p)]));
        s.root = {std::cbrt(value.x), std::cbrt(value.y), std::cbrt(value.z)};
        samples.push_back(s);
      }
    }
  }
  return samples;
}

}  // namespace maquette
