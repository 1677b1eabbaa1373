#pragma once

#include <Eigen/Core>
#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "render/slf/incident.h"
#include "render/slf/response.h"

namespace maquette {

enum class LightBasis {
  bins,       ///< the direct sum over all bins
  harmonics,  ///< spherical harmonics of bands 0 to 5
  haar,       ///< the Haar coefficients that matter, as many as keep the error
};

/// Projects incident bins to a basis and multiplies them with a material's response there.
class LightTransport {
 public:
  /// `error`: of the outgoing radiance, relative, that `haar` may add.
  LightTransport(const LightResponse& response, const Lumisphere& lumisphere, LightBasis basis, double error);
  /// `incident`: [channel] matrices [bin][texel]; adds to `out`, the same. Returns the coefficients used.
  std::size_t apply(const std::array<Eigen::MatrixXf, 3>& incident, std::array<Eigen::MatrixXf, 3>* out) const;

 private:
  std::size_t apply_haar(const std::array<Eigen::MatrixXf, 3>& incident, std::array<Eigen::MatrixXf, 3>* out) const;

  LightBasis basis_;
  double error_;
  Eigen::MatrixXf project_;                  ///< [coefficient][bin]
  std::array<Eigen::MatrixXf, 3> response_;  ///< [channel][bin out][coefficient]
  Eigen::VectorXf norms_;                    ///< [coefficient] of its responses, all channels
  // Of `haar`: what is left out keeps its mean, weighted by the cosine, so that a diffuse surface gets all of it.
  Eigen::VectorXf mean_of_bins_, mean_of_coefficients_;  ///< what one of each brings to the mean
  std::array<Eigen::VectorXf, 3> albedo_;                ///< [channel][bin out] of the response, under a light of 1
};

struct OutgoingOptions {
  LightBasis basis = LightBasis::haar;
  double haar_error = 0.005;
  float texel_m = 0.0f;  ///< textures are filtered over this; 0: not
};

/// Radiance that leaves the texels, without emission. radiance: [3 bin + channel][texel], coefficients of a
/// DirectionSpline, cd/m2.
struct OutgoingField {
  Eigen::MatrixXf radiance;
  double coefficients = 0.0;  ///< mean per texel and channel
};

/// Why a material cannot be kept in lumispheres, or nothing: normal maps and anisotropy turn its frame.
std::string check_light_field_material(const Material& material);
/// Throws Error naming the material where there is a reason.
void require_light_field_material(const Material& material);

/// From incident light and the materials of `scene`, whose geometry is that of the bake. Throws Error for materials of
/// check_light_field_material. Null once cancelled.
std::shared_ptr<const OutgoingField> compute_outgoing(const PathScene& scene, const LightFieldAtlas& atlas,
                                                      const IncidentField& incident, const OutgoingOptions& options,
                                                      const std::atomic<bool>& cancel);

/// [3 bin + channel] solid angle of each dimension of an outgoing field, for errors and compression.
Eigen::VectorXf outgoing_measure(const Lumisphere& lumisphere);
/// RMS of the difference, weighted by solid angle, relative to the mean of `truth`; 0 where both are black.
double field_error(const Eigen::MatrixXf& field, const Eigen::MatrixXf& truth, const Eigen::VectorXf& measure);

}  // namespace maquette
