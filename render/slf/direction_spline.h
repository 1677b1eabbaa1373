#pragma once

#include <Eigen/Core>
#include <array>
#include <glm/glm.hpp>
#include <map>
#include <memory>
#include <mutex>
#include <vector>

#include "render/slf/lumisphere.h"

namespace maquette {

/// Functions of direction as sums of quadratic B-splines about the cells of a lumisphere, in the plane of its map; a
/// cell without a bin counts with the bin next to it. Constants are represented exactly.
/// Piecewise constant light and bilinear reads blur lobes: 16 x 16 bins at GGX alpha 0.3 are off by 4 and 8 %, splines
/// by 2 % (docs/numerics/surface-light-fields.md).
class DirectionSpline {
 public:
  explicit DirectionSpline(const Lumisphere& lumisphere);

  /// Weights of coefficients at a direction, sum 1.
  struct Share {
    int bin = 0;
    float weight = 0.0f;
  };
  std::array<Share, 9> shares(const glm::vec3& direction) const;
  /// The same at a point of the lumisphere's map, in cells from its corner. `step`: for a table of such points, this
  /// far apart in cells, which is read bilinearly: less what that adds on average, step^2 / 12 of the second
  /// derivative.
  static std::array<Share, 9> shares_at(const Lumisphere& lumisphere, const glm::vec2& cells, float step = 0.0f);
  /// Of coefficients [bin].
  float value(const Eigen::VectorXf& coefficients, const glm::vec3& direction) const;

  /// Points of a bin with weights that sum to 1: functions times weights are cosine-weighted means.
  using BinSample = Lumisphere::Sample;
  std::vector<BinSample> bin_samples(int bin, int samples) const;
  /// [bin][bin]: coefficients of the light whose means over `samples` squared points of each bin are given. Computed
  /// once; from any thread.
  const Eigen::MatrixXf& from_means(int samples) const;

  /// Directions at which a function is fitted by least squares over solid angle.
  const std::vector<glm::vec3>& views() const { return views_; }
  /// [bin][view]: coefficients of the function with these values.
  const Eigen::MatrixXf& fit() const { return fit_; }
  /// [bin][bin]: coefficients of the function with values at the lumisphere's directions.
  const Eigen::MatrixXf& interpolate() const { return interpolate_; }
  const Lumisphere& lumisphere() const { return lumisphere_; }

 private:
  struct Solved {
    std::mutex mutex;
    std::map<int, Eigen::MatrixXf> of_samples;
  };
  Eigen::MatrixXd values_at(const std::vector<glm::vec3>& directions) const;
  Eigen::MatrixXf solve_means(int samples) const;

  const Lumisphere lumisphere_;
  std::vector<glm::vec3> views_;
  Eigen::MatrixXf fit_, interpolate_;
  std::shared_ptr<Solved> solved_ = std::make_shared<Solved>();
};

}  // namespace maquette
