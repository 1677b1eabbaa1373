#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "render/environment/packed_sky.h"
#include "scenes/environment.h"

namespace maquette {

/// Lobes through which the sky's bandwidth is tabulated: nu_rho of number k is seen_through(k) cycles/rad.
inline constexpr std::size_t kSeenBandwidthCount = 9;
constexpr double seen_through(std::size_t k) { return 0.5 * static_cast<double>(1u << k); }

/// Tables derived once per environment and cached by content; independent of its rotation. No OpenGL.
struct EnvironmentTables {
  int width = 0, height = 0;           ///< of the importance grid: the environment's own
  std::vector<float> marginal_cdf;     ///< [height + 1] over rows
  std::vector<float> conditional_cdf;  ///< [height][width + 1]
  /// [height][width] density over solid angle of each texel's cell (1/sr) with which directions in it are
  /// drawn. Proportional to the cell's mean bilinear (R + G + B) / 3, so 0 only where all of it is 0.
  std::vector<float> density;
  double luminance_integral = 0.0;  ///< of Y over the sphere, stored units * sr; 0 for a black environment
  int bandwidth_width = 0, bandwidth_height = 0;
  /// nu_L: local angular bandwidth, cycles per radian of direction, [bandwidth_height][bandwidth_width], latlong;
  /// sin(theta) of longitude undone. Daubechies-4 wavelets; local (a sun does not raise the whole sky).
  std::vector<float> bandwidth;
  /// nu_L as it is seen through a lobe, [bandwidth_height][bandwidth_width][kSeenBandwidthCount], at most nu_L.
  std::vector<float> seen_bandwidth;
};
EnvironmentTables compute_environment_tables(const Environment& environment);
EnvironmentTables load_environment_tables(const Environment& environment);  ///< through the disk cache

/// A direction drawn by importance: in proportion to the bilinear light, not only to its mean by cell. What light over
/// density varies within the cells of a sun is noise wherever it shines: a quarter of the square under the clear sky.
struct EnvironmentDirection {
  glm::vec3 direction;
  float pdf;           ///< 1/sr
  float map_x, map_y;  ///< texels, centres at half-integers
};
/// Interval of a cumulative table that holds u, and where inside it; never one of probability 0.
struct EnvironmentCell {
  std::size_t index;
  double position;  ///< in [0, 1]
};
EnvironmentCell find_environment_cell(const float* cdf, std::size_t count, double u);
/// A point of the map: column position `x` (texels, below the width), and `t` in [0, 1] of its row by solid angle.
struct EnvironmentPoint {
  std::size_t row = 0;
  double x = 0.0, t = 0.0;
};
/// What the importance tables make of u, v in [0, 1)^2. The environment must not be black.
EnvironmentPoint sample_environment_point(const EnvironmentTables& tables, double u, double v);
EnvironmentDirection sample_environment_direction(const Environment& environment, const EnvironmentTables& tables,
                                                  double u, double v);

/// One light sample: a direction and one of the four nodes of the packed sky around it. Light of a direction is their
/// mean by bilinear weights; a shader that meets it by BRDF sampling chooses one by these weights. Both strategies must
/// weigh the same thing: with the bilinear radiance here, the balance heuristic (not linear in radiance) loses up to 6
/// % of a sun that a glossy surface mirrors.
struct EnvironmentSample {
  glm::vec3 direction;
  float pdf;           ///< 1/sr: joint density of direction and node, over the node's bilinear weight
  glm::vec3 radiance;  ///< of the node
  float padding = 0.0f;
};
/// `count` samples of a scrambled low-discrepancy sequence (any prefix or run of consecutive ones is well spread)
/// warped by the importance tables. Deterministic for a seed. Empty for a black environment.
std::vector<EnvironmentSample> sample_environment(const Environment& environment, const EnvironmentTables& tables,
                                                  const PackedSky& sky, std::uint32_t seed, std::size_t count);

}  // namespace maquette
