#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "render/visibility/visibility_points.h"

namespace maquette {

inline constexpr std::size_t kVisibilityWords = 18;
/// The visibility bits of both sides of a vertex, +n first, as shaders read them (shaders/shared/visibility.glsl).
using VisibilitySides = std::array<std::array<std::uint32_t, kVisibilityWords>, 2>;

/// Cells below the tangent plane hold the visibility of the other side. In the result, those near the horizon repeat
/// the nearest cell above it, so that lookups in upward directions, also between vertices, only read this side.
std::vector<VisibilitySides> visibility_sides(const std::vector<VisibilityBits>& bits,
                                              const std::vector<glm::vec3>& normals);

}  // namespace maquette
