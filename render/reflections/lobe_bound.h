#pragma once

#include <array>
#include <functional>
#include <glm/glm.hpp>

namespace maquette {

/// How bright a small lamp can look in a surface: the largest f cos theta_i of its BRDF (its largest channel) by how
/// far the half vector is from the normal, and the two directions from it.
struct LobeBound {
  static constexpr int kHalfAngles = 64, kDifferences = 16;
  /// 1/sr: [bin of cos theta_d][from theta_h = pi / 2 (k / 64)^2 on]
  std::array<std::array<float, kHalfAngles>, kDifferences> peak{};
  /// For half vectors `theta_h_rad` or more from the normal, cos theta_d in [low, high].
  float peak_beyond(float theta_h_rad, float low, float high) const;
  float largest() const { return peak_beyond(0.0f, 0.0f, 1.0f); }
};

/// Samples `f(wi, wo)` (local, above the horizon) on a grid of half vectors and views, and adds a margin for what lies
/// between: about 12,000 calls.
LobeBound make_lobe_bound(const std::function<float(const glm::vec3& wi, const glm::vec3& wo)>& f);

/// Of a surface of which nothing is known: it may mirror all.
LobeBound unknown_lobe();

}  // namespace maquette
