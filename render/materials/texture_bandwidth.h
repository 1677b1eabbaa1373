#pragma once

#include <vector>

#include "render/materials/texture_atlas.h"
#include "scenes/scene.h"

namespace maquette {

inline constexpr int kTextureBandwidthSide = 16;

/// Local bandwidth of a texture's luminance on a 16 x 16 grid of regions ([v][u]), in cycles per unit of UV (the larger
/// of both axes): the frequency below which 95 % of a region's energy lies, from a Daubechies-4 transform; the mean
/// counts as frequency 0.
std::vector<float> compute_texture_bandwidth(const TextureImage& image);

/// The same of data: the largest over `channels` (bit k: channel k), of what varies, whatever the mean; what varies by
/// less than a step of 8 bits is flat. Colour that is multiplied with light is interpolated without its texture; data
/// are in the light itself.
std::vector<float> compute_data_bandwidth(const TextureImage& image, unsigned channels);

/// Channels that are read of a role's texture, as bits; 0: colour, and normals, which are compared where points are
/// interpolated.
unsigned data_channels(TextureRole role);

}  // namespace maquette
