#pragma once

#include <cstdint>
#include <vector>

#include "render/math/shared_formulas.h"
#include "render/scene_state/geometry.h"

namespace maquette {

/// 64 bytes, std430; declared for both sides in shaders/shared/lights.glsl.
using LightRecord = shared::LightRecord;

inline constexpr std::uint32_t kNoTriangle = 0xffffffffu;  ///< triangle index of a punctual light

/// Punctual lights and the triangles of emissive materials. At most `max_triangles` triangles are kept, the strongest
/// first; `dropped_power` is the share of the power left out (0 in ordinary scenes).
///
/// Power is luminous flux in lumens (of luminance Y); a directional light's is its lux times the cross-section of the
/// scene's bounding sphere. Lights and triangles without power, without area or with values that are not finite are
/// left out. A triangle's radiance is the mean of the emissive texture over it.
struct LightList {
  std::vector<LightRecord> lights;
  std::vector<std::uint32_t> triangles;  ///< [light] triangle of the geometry (index of its first corner / 3)
  double dropped_power = 0.0;
  double diagonal_m = 0.0;  ///< diameter of the scene's bounding sphere
};
LightList build_light_list(const Scene& scene, const FlatGeometry& geometry, int variant, int max_triangles = 8192);

/// Cumulative probabilities in proportion to `weights`, in steps of 2^-24. The probability of drawing an entry (a
/// uniform number of 24 bits below it) then equals the probability that the estimate is divided by, to the last bit.
/// With rounded entries, lights of 1e-7 of the power were drawn up to twice as often as stated. Every entry keeps at
/// least one step; the largest entry absorbs what that and rounding add up to.
std::vector<float> cumulative_in_steps(const std::vector<double>& weights);

}  // namespace maquette
