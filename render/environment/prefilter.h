#pragma once

#include <vector>

#include "scenes/environment.h"
#include "scenes/image.h"

namespace maquette {

/// Environments convolved with lobes that are symmetric about the lookup direction, for the prefiltered modes. Every
/// map is latitude-longitude like Environment (3 channels, twice as wide as high), no larger than its lobe needs, and
/// normalised so that a constant sky stays unchanged. Deterministic, without noise, parallel, cached by content.

/// GGX at roughness r = i / (level_count - 1), alpha = r^2, one map a level. Level 0 is the environment itself, at most
/// 1024 x 512; the others 256 x 128 down to 32 x 16. level_count >= 2.
/// Source: Karis 2013, "Real Shading in Unreal Engine 4": normal, view and reflection are one direction, samples
/// weighted by n.l.
std::vector<Image> prefilter_ggx(const Environment& environment, int level_count);

/// The normalised spherical Gaussian exp(sharpness (cos(angle) - 1)) for each sharpness > 0; at most 512 x 256.
std::vector<Image> prefilter_sg(const Environment& environment, const std::vector<float>& sharpness);

/// Irradiance over pi: the radiance of a white Lambertian surface with that normal. 32 x 16.
Image prefilter_diffuse(const Environment& environment);

/// Split-sum table: channel 0 scales F0, channel 1 is added. [size rows: roughness (y + 0.5) / size][size: n.v = (x +
/// 0.5) / size]. GGX, separable Smith masking, Schlick's Fresnel. Source: Karis 2013. Not cached: about 50 ms for 64.
Image split_sum_table(int size);

}  // namespace maquette
