#pragma once

#include <Eigen/Core>
#include <span>

#include "render/slf/direction_spline.h"
#include "scenes/btf/btf.h"

namespace maquette {

/// How the frame of a BTF lies in that of a texel: turned about the normal by whole steps, mirrored or not.
struct BtfTurn {
  static constexpr int kSteps = 128;  ///< 2.8 degrees: bins are 7 and more apart, views 15
  int step = 0;
  bool mirrored = false;
  auto operator<=>(const BtfTurn&) const = default;
  glm::vec3 to_btf(const glm::vec3& local) const;
  glm::vec3 from_btf(const glm::vec3& direction) const;
};
/// `t`, `b`: axes of the BTF in the texel's frame, unit, across its normal.
BtfTurn btf_turn(const glm::vec2& t, const glm::vec2& b);

/// What a BTF makes of light in bins, for texels whose frames lie the same way. A view's light weights are scalars, so
/// that light is summed once for each view and component, and texels of the BTF come in by their factors alone.
class BtfResponse {
 public:
  BtfResponse(const Btf& btf, const DirectionSpline& spline, const BtfTurn& turn);
  /// `incident`, `out`: [channel] [bin][texel], means of the bins and coefficients of outgoing light.
  void apply(std::span<const BtfLookup> at, const std::array<Eigen::MatrixXf, 3>& incident,
             std::array<Eigen::MatrixXf, 3>* out) const;
  /// The same in two steps, for many texels under one light: what the views' terms have of it, [view, 1 + component];
  /// and outgoing light of given factors [(view, 1 + component), channel]. Of one channel.
  Eigen::VectorXf light_of_terms(const Eigen::VectorXf& incident) const { return light_ * incident; }
  const Eigen::MatrixXf& light() const { return light_; }
  Eigen::VectorXf apply_factors(const Eigen::VectorXf& factors, Eigen::Index channel,
                                const Eigen::VectorXf& light) const;

 private:
  const Btf& btf_;
  Eigen::MatrixXf light_;  ///< [view, 1 + component][bin]: of the mean and of each component, times the cosine, sr
  Eigen::MatrixXf views_;  ///< [bin][view]: coefficients of the interpolation between views
};

}  // namespace maquette
