#pragma once

#include <bit>
#include <cstdint>

namespace maquette {

/// Of a finite half float, denormals included. No float here is denormal: the ray tracer makes its threads take those
/// as zero, and results must not depend on the thread.
inline float float_of_half(std::uint16_t half) {
  const std::int32_t magnitude = half & 0x7fff;
  const float small = static_cast<float>(magnitude) * 0x1p-24f;
  const float normal = std::bit_cast<float>((magnitude << 13) + (112 << 23));
  const float value = magnitude < 0x400 ? small : normal;
  return std::bit_cast<float>(std::bit_cast<std::uint32_t>(value) | static_cast<std::uint32_t>(half & 0x8000) << 16);
}

/// To the nearest, ties to even; what is too large becomes the largest half float.
inline std::uint16_t half_of_float(float value) {
  const std::uint32_t bits = std::bit_cast<std::uint32_t>(value);
  const auto sign = static_cast<std::uint16_t>(bits >> 16 & 0x8000);
  const float magnitude = std::bit_cast<float>(bits & 0x7fffffff);
  if (!(magnitude < 65504.0f)) return sign | 0x7bff;
  if (magnitude < 0x1p-14f)  // denormal: the sum rounds to multiples of 2^-24
    return sign | static_cast<std::uint16_t>(std::bit_cast<std::uint32_t>(magnitude + 0.5f) -
                                             std::bit_cast<std::uint32_t>(0.5f));
  const std::uint32_t m = std::bit_cast<std::uint32_t>(magnitude);
  return sign | static_cast<std::uint16_t>((m + 0xfff + (m >> 13 & 1) - (112u << 23)) >> 13);
}

}  // namespace maquette
