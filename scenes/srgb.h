#pragma once

#include <cmath>

namespace maquette {

// The transfer function of sRGB, both ways, in [0, 1]. Source: IEC 61966-2-1.
inline double linear_from_srgb(double v) { return v <= 0.04045 ? v / 12.92 : std::pow((v + 0.055) / 1.055, 2.4); }
inline double srgb_from_linear(double v) { return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1.0 / 2.4) - 0.055; }

}  // namespace maquette
