#pragma once

#include <bit>
#include <cstdint>
#include <glm/glm.hpp>

#ifndef MAQUETTE_FN
#define MAQUETTE_FN inline
#endif

namespace maquette::shared {
using namespace glm;
inline std::uint32_t floatBitsToUint(float x) { return std::bit_cast<std::uint32_t>(x); }
inline float uintBitsToFloat(std::uint32_t x) { return std::bit_cast<float>(x); }
#include "shared/rgb9e5.glsl"
}  // namespace maquette::shared
