#pragma once

#include <array>

#include "render/metrics/planes.h"

namespace maquette::flip {

/// A contrast sensitivity function in the spatial domain: the sum of two separable Gaussians, with all taps summing to
/// 1. The second may be empty.
struct SpatialFilter {
  Kernel first, second;
};
/// Filters of the channels Y, Cx, Cz. Source: Andersson et al. 2020, Section 4.1.1, Eq. 3 and Table 1.
std::array<SpatialFilter, 3> spatial_filters(double pixels_per_degree);
Plane apply(const SpatialFilter& filter, const Plane& plane);

/// One-dimensional parts of the feature detectors: the Gaussian sums to 1; the positive and the negative weights of the
/// derivatives to 1 and -1. Source: Andersson et al. 2020, Section 4.2.
struct FeatureFilters {
  Kernel gaussian, edge, point;
};
FeatureFilters feature_filters(double pixels_per_degree);

}  // namespace maquette::flip
