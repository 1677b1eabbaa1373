#pragma once

#include <Eigen/Core>
#include <array>

#include "render/reference/surface.h"
#include "render/slf/direction_spline.h"

namespace maquette {

/// What a material makes of incident light: outgoing radiance is, for each channel, this matrix times the light.
/// [channel][out][in], in sr/sr: the BRDF times the cosine, integrated.
struct LightResponse {
  std::array<Eigen::MatrixXf, 3> channels;
};

/// From the mean light of the bins to coefficients of outgoing light (DirectionSpline::fit). `point`: material,
/// analytic lobes and tint; its wo is replaced. Each incident bin is integrated at `samples` squared points.
LightResponse compute_response(const SurfacePoint& point, const DirectionSpline& spline, int samples);
/// From coefficients of incident light to values towards the lumisphere's directions.
LightResponse compute_response_of_coefficients(const SurfacePoint& point, const DirectionSpline& spline, int samples);

/// Samples that narrow lobes need in a bin.
int response_samples(const SurfacePoint& point);

/// Half of the width (rad) at half maximum of the narrowest peak of the lobe over light directions, seen at 45 degrees;
/// pi where there is none above the rest.
double peak_half_width(const SurfacePoint& point);

/// Side of the lumispheres from which their bins resolve that peak.
int lumisphere_side_for(double peak_half_width_rad);

}  // namespace maquette
