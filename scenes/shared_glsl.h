#pragma once

// What the files of shaders/shared need before them as C++: the very lines that the GPU compiles, included inside a
// namespace that has GLM's names.
#include <bit>
#include <cstdint>
#include <glm/glm.hpp>

// Each file keeps the copies that it compiled: of an inline function the linker would take any one, that of a file with
// fewer optimisations too.
#define MAQUETTE_FN static inline

namespace maquette::shared {
using namespace glm;
inline std::uint32_t floatBitsToUint(float x) { return std::bit_cast<std::uint32_t>(x); }
inline float uintBitsToFloat(std::uint32_t x) { return std::bit_cast<float>(x); }
}  // namespace maquette::shared
