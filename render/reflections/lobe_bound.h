#pragma once

#include <array>
#include <functional>
#include <glm/glm.hpp>

namespace maquette {

/// How bright a small lamp can appear in a surface: the largest f cos theta_i of its BRDF (its largest channel), by the
/// angle of the half vector from the normal and that of the two directions from the half vector.
struct LobeBound {
  static constexpr int kHalfAngles = 64, kDifferences = 16;
  /// 1/sr: [bin of cos theta_d][from theta_h = pi / 2 (k / 64)^2 on]
  std::array<std::array<float, kHalfAngles>, kDifferences> peak{};
  /// Bound for half vectors at least `theta_h_rad` from the normal, and cos theta_d in [low, high].
  float peak_beyond(float theta_h_rad, float low, float high) const;
  float largest() const { return peak_beyond(0.0f, 0.0f, 1.0f); }
};

/// Samples `f(wi, wo)` (local, above the horizon) on a grid of half vectors and views, and adds a margin for values
/// between the samples: about 12,000 calls.
LobeBound make_lobe_bound(const std::function<float(const glm::vec3& wi, const glm::vec3& wo)>& f);

/// Bound for an unknown surface: it may be a perfect mirror.
LobeBound unknown_lobe();

}  // namespace maquette
