#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "render/environment/packed_sky.h"
#include "scenes/environment.h"

namespace maquette {

/// Number of lobes for which the filtered bandwidth of the sky is tabulated: lobe k has nu_rho = seen_through(k)
/// cycles/rad.
inline constexpr std::size_t kSeenBandwidthCount = 9;
constexpr double seen_through(std::size_t k) { return 0.5 * static_cast<double>(1u << k); }

/// Tables derived once per environment and cached by content; independent of its rotation. No OpenGL.
struct EnvironmentTables {
  int width = 0, height = 0;           ///< of the importance grid: the environment's own
  std::vector<float> marginal_cdf;     ///< [height + 1] over rows
  std::vector<float> conditional_cdf;  ///< [height][width + 1]
  /// [height][width] sampling density of each texel's cell over solid angle (1/sr). Proportional to the cell's mean
  /// bilinear (R + G + B) / 3, so it is 0 only where the whole cell is black.
  std::vector<float> density;
  double luminance_integral = 0.0;  ///< of luminance over the sphere, stored units * sr; 0 for a black environment
  int bandwidth_width = 0, bandwidth_height = 0;
  /// nu_L: local angular bandwidth, cycles per radian of direction, [bandwidth_height][bandwidth_width], latlong,
  /// corrected for the stretching of longitude. Daubechies-4 wavelets; local: a sun does not raise the whole sky.
  std::vector<float> bandwidth;
  /// nu_L after filtering by each lobe, [bandwidth_height][bandwidth_width][kSeenBandwidthCount], at most nu_L.
  std::vector<float> seen_bandwidth;
};
EnvironmentTables compute_environment_tables(const Environment& environment);
EnvironmentTables load_environment_tables(const Environment& environment);  ///< through the disk cache

/// A direction sampled by importance, in proportion to the bilinear light and not only to the mean of its cell.
/// Otherwise the variation of light over density within the cells of a sun would appear as noise: a quarter of the
/// variance under the clear sky.
struct EnvironmentDirection {
  glm::vec3 direction{};
  float pdf;           ///< 1/sr
  float map_x, map_y;  ///< texels, centres at half-integers
};
/// Interval of a cumulative table that contains u, and the position within it; never an interval of probability 0.
struct EnvironmentCell {
  std::size_t index;
  double position;  ///< in [0, 1]
};
EnvironmentCell find_environment_cell(const float* cdf, std::size_t count, double u);
/// A point of the map: column position `x` (texels, below the width), and `t` in [0, 1] within its row, uniform in
/// solid angle.
struct EnvironmentPoint {
  std::size_t row = 0;
  double x = 0.0, t = 0.0;
};
/// Warps u, v in [0, 1)^2 by the importance tables. The environment must not be black.
EnvironmentPoint sample_environment_point(const EnvironmentTables& tables, double u, double v);
EnvironmentDirection sample_environment_direction(const Environment& environment, const EnvironmentTables& tables,
                                                  double u, double v);

/// One light sample: a direction and one of the four nodes of the packed sky around it. The light of a direction is the
/// mean of the nodes with bilinear weights; a shader that reaches it by BRDF sampling selects one node by these
/// weights. Both strategies must use the same radiance: with the bilinear radiance here, the balance heuristic (not
/// linear in radiance) would lose up to 6 % of a sun that a glossy surface mirrors.
struct EnvironmentSample {
  glm::vec3 direction{};
  float pdf;             ///< 1/sr: joint density of direction and node, divided by the node's bilinear weight
  glm::vec3 radiance{};  ///< of the node
  float padding = 0.0f;
};
/// `count` samples of a scrambled low-discrepancy sequence (prefixes and runs of consecutive samples are well
/// distributed) warped by the importance tables. Deterministic for a seed. Empty for a black environment.
std::vector<EnvironmentSample> sample_environment(const Environment& environment, const EnvironmentTables& tables,
                                                  const PackedSky& sky, std::uint32_t seed, std::size_t count);

}  // namespace maquette
