#pragma once

// What the files of shaders/shared need before them as C++: the very lines that the GPU compiles, included inside a
// namespace that has GLM's names.
#include <bit>
#include <cstdint>
#include <glm/glm.hpp>

#define MAQUETTE_FN inline

namespace maquette::shared {
using namespace glm;
inline std::uint32_t floatBitsToUint(float x) { return std::bit_cast<std::uint32_t>(x); }
inline float uintBitsToFloat(std::uint32_t x) { return std::bit_cast<float>(x); }
}  // namespace maquette::shared
