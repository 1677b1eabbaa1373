#include "render/reflections/lobe_bound.h"

#include <algorithm>
#include <cmath>

namespace maquette {

namespace {

constexpr int kAzimuths = 12;  // half the circle, because f is isotropic
constexpr float kHalfPi = 1.57079633f;
constexpr float kMargin = 1.1f;  // for values between the samples
constexpr float kUnknownPeak = 1e9f;

}  // namespace

float LobeBound::peak_beyond(float theta_h_rad, float low, float high) const {
  const float k = std::sqrt(std::max(theta_h_rad, 0.0f) / kHalfPi) * kHalfAngles;
  const auto h = static_cast<std::size_t>(std::clamp(static_cast<int>(k) - 1, 0, kHalfAngles - 1));
  const auto bin = [](float c) { return std::clamp(static_cast<int>(std::floor(c)), 0, kDifferences - 1); };
  float most = 0.0f;
  for (int d = bin(low * kDifferences - 0.5f); d <= bin(high * kDifferences + 0.5f); ++d)
    most = std::max(most, peak[static_cast<std::size_t>(d)][h]);
  return most;
}

LobeBound make_lobe_bound(const std::function<float(const glm::vec3& wi, const glm::vec3& wo)>& f) {
  LobeBound bound;
  for (int d = 0; d < LobeBound::kDifferences; ++d) {
    std::array<float, LobeBound::kHalfAngles>& peak = bound.peak[static_cast<std::size_t>(d)];
    const float cos_d = (static_cast<float>(d) + 0.5f) / LobeBound::kDifferences,
                sin_d = std::sqrt(1.0f - cos_d * cos_d);
    for (int h = 0; h < LobeBound::kHalfAngles; ++h) {
      const float t = (static_cast<float>(h) + 0.5f) / LobeBound::kHalfAngles, theta = kHalfPi * t * t;
      const glm::vec3 half(std::sin(theta), 0.0f, std::cos(theta)), across(std::cos(theta), 0.0f, -std::sin(theta));
      float& most = peak[static_cast<std::size_t>(h)];
      for (int a = 0; a < 2 * kAzimuths; ++a) {
        const float phi = 2.0f * kHalfPi * (static_cast<float>(a) + 0.5f) / kAzimuths;
        const glm::vec3 off = sin_d * (std::cos(phi) * across + std::sin(phi) * glm::vec3(0.0f, 1.0f, 0.0f));
        const glm::vec3 wi = cos_d * half + off, wo = cos_d * half - off;
        if (wi.z > 0.0f && wo.z > 0.0f) most = std::max(most, kMargin * f(wi, wo) * wi.z);
      }
    }
    for (std::size_t k = LobeBound::kHalfAngles - 1; k-- > 0;) peak[k] = std::max(peak[k], peak[k + 1]);
  }
  return bound;
}

LobeBound unknown_lobe() {
  LobeBound bound;
  for (auto& row : bound.peak) row.fill(kUnknownPeak);
  return bound;
}

}  // namespace maquette
