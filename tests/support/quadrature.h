#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

#include "scenes/brdf.h"
#include "scenes/environment.h"

namespace maquette::test {

/// Moments of the environment's bilinear radiance over square blocks of texels, for product integration: where the rest
/// of the integrand is a biquadratic polynomial over a block, the integral is exact for any radiance.
///
/// Level l is a cell of 2^l half texels: levels 0 and below are bilinear; levels 2 and up are stored (54 bytes a
/// texel).
class EnvironmentMoments {
 public:
  explicit EnvironmentMoments(const Environment& environment);

  /// m[3 p + q] = integral of L a^p b^q dx dy, in texels^2; a, b in [-1, 1] across the cell. The cell begins at
  /// (x, y) texels, a multiple of its side 2^(level - 1).
  using Moments = std::array<glm::dvec3, 9>;
  Moments moments(int level, double x, double y) const;

  int width() const { return width_; }
  int height() const { return height_; }
  int top_level() const { return top_level_; }

 private:
  Moments bilinear_moments(double x, double y, double side) const;
  glm::dvec3 texel(long x, long y) const;
  glm::dvec3 radiance(double x, double y) const;

  struct Level {
    int columns = 0, rows = 0;
    std::vector<Moments> blocks;
  };
  int width_, height_, top_level_;
  std::vector<glm::vec3> rgb_;
  std::vector<Level> levels_;  // [level - 2]
};

struct DirectQuadratureOptions {
  double relative_tolerance = 1e-4;  ///< of the sum of the error estimates of all cells
  std::size_t max_cells = 60000;     ///< 25 evaluations for the first, 16 for each more
};

struct DirectQuadrature {
  glm::dvec3 radiance{0.0};
  double relative_error = 0.0;  ///< estimate; larger than the tolerance if max_cells was reached
  std::size_t evaluations = 0;
};

/// Integral over the sphere of environment(w) * weight(w) dw by adaptive product integration in the map. `weight` is
/// zero more than a right angle from `normal` and may have a narrow lobe about `focus` (both unit).
DirectQuadrature integrate_environment(const EnvironmentMoments& environment,
                                       const std::function<glm::dvec3(const glm::dvec3&)>& weight,
                                       const glm::dvec3& normal, const glm::dvec3& focus,
                                       const DirectQuadratureOptions& options = {});

/// A surface point lit by the environment alone.
struct LitPoint {
  glm::dvec3 normal{0.0, 1.0, 0.0};  ///< unit
  glm::dvec3 wo{0.0, 1.0, 0.0};      ///< unit, to the viewer
  /// Environment rotation about +Y, positive from +Z towards +X.
  double env_rotation_rad = 0.0;
  /// Unoccluded share of a world direction; none: 1 everywhere.
  std::function<double(const glm::dvec3&)> visibility;
};

/// Reflected radiance: integral of L f cos. In double, from evaluate_brdf and the environment's own texels; uses no
/// samples. Costs 10 to 40 ms on one core (50,000 to 100,000 evaluations).
DirectQuadrature evaluate_direct(const EnvironmentMoments& environment, const BrdfTable& brdf, const LitPoint& point,
                                 const DirectQuadratureOptions& options = {});

}  // namespace maquette::test
