#pragma once

#include <vector>

#include "scenes/scene.h"

namespace maquette {

inline constexpr int kTextureBandwidthSide = 16;

/// Local bandwidth of a texture's luminance on a 16 x 16 grid of regions ([v][u]), in cycles per unit of UV (the larger
/// of both axes): the frequency below which 95 % of a region's energy lies, from a Daubechies-4 transform; the mean
/// counts as frequency 0.
std::vector<float> compute_texture_bandwidth(const TextureImage& image);

}  // namespace maquette
