#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace maquette {

/// A blended surface between a mirrored ray's origin and its hit.
struct MirroredLayer {
  std::uint32_t pixel = 0;
  std::uint32_t triangle = 0;  ///< of the geometry
  glm::vec3 share{0.0f};       ///< of its light that is seen: its alpha, and what lies before it
};

/// So many along a ray are shaded; those behind look like the last one.
inline constexpr int kMostMirroredLayers = 4;
/// By their order along the rays, the nearest first.
using MirroredLayers = std::array<std::vector<MirroredLayer>, kMostMirroredLayers>;

}  // namespace maquette
