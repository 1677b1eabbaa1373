#pragma once

#include <Eigen/Core>
#include <array>

#include "render/reference/surface.h"
#include "render/slf/lumisphere.h"

namespace maquette {

/// What a material makes of the light in bins: outgoing radiance towards the directions of a lumisphere's bins is, for
/// each channel, this matrix times the incident bins. [channel][bin out][bin in], in sr/sr: the BRDF times the cosine,
/// integrated over the incident bin.
struct LightResponse {
  std::array<Eigen::MatrixXf, 3> channels;
};

/// `point`: material, analytic lobes and tint; its wo is replaced. Each incident bin is integrated at `samples` squared
/// points.
LightResponse compute_response(const SurfacePoint& point, const Lumisphere& lumisphere, int samples);

/// Samples that narrow lobes need in a bin.
int response_samples(const SurfacePoint& point);

/// Half of the width (rad) at half maximum of the narrowest peak of the lobe over light directions, seen at 45 degrees;
/// pi where there is none above the rest.
double peak_half_width(const SurfacePoint& point);

/// Side of the lumispheres from which their bins resolve that peak.
int lumisphere_side_for(double peak_half_width_rad);

}  // namespace maquette
