#pragma once

#include <map>
#include <string>
#include <vector>

#include "scenes/image.h"

namespace maquette {

/// Reads .exr or .hdr (Radiance) as linear float, 3 or 4 channels (R, G, B, then A if there is one).
/// Throws Error: unreadable, truncated, missing R/G/B channels, absurd size. What could not be followed is added to
/// `warnings`.
Image load_hdr_image(const std::string& path, std::vector<std::string>* warnings = nullptr);

/// Further images of an EXR file by name: the layer `variance` has the channels variance.R, variance.G, variance.B.
using ImageLayers = std::map<std::string, Image>;

/// Writes a linear image as EXR, 32-bit float (alpha kept), to a temporary file that is then renamed.
/// `attributes` become string attributes of the header; `layers` have the image's size. Throws Error and leaves no
/// partial file.
void save_exr(const std::string& path, const Image& image, const std::map<std::string, std::string>& attributes = {},
              const ImageLayers& layers = {});

/// Writes a tone mapped image (display-encoded, 0..1) as 8-bit PNG, to a temporary file that is then renamed. Opaque:
/// alpha is 0 where the sky is visible, and the sky belongs to the picture.
void save_png(const std::string& path, const Image& image);

}  // namespace maquette
