#include "scenes/texels.h"

#include <cmath>

#include "scenes/srgb.h"

namespace maquette {

namespace {

/// Linear values of the codes of a channel.
std::vector<float> make_decoding(std::size_t codes, bool srgb) {
  std::vector<float> out(codes);
  for (std::size_t i = 0; i < codes; ++i) {
    const double v = static_cast<double>(i) / static_cast<double>(codes - 1);
    out[i] = static_cast<float>(srgb ? linear_from_srgb(v) : v);
  }
  return out;
}

const float* decoding(bool fine, bool srgb) {
  static const std::vector<float> kColour = make_decoding(256, true), kPlain = make_decoding(256, false);
  if (!fine) return srgb ? kColour.data() : kPlain.data();
  static const std::vector<float> kFineColour = make_decoding(65536, true), kFinePlain = make_decoding(65536, false);
  return srgb ? kFineColour.data() : kFinePlain.data();
}

}  // namespace

Texels::Texels(const TextureImage& image, bool srgb)
    : image_(image), colour_(decoding(!image.rgba16.empty(), srgb)), plain_(decoding(!image.rgba16.empty(), false)) {}

}  // namespace maquette
