#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace maquette {

/// Whether some triangles turn their front to the eye and others their back: such a surface may lie behind itself.
/// `indices`: three a triangle; `eye` in the space of `positions`.
bool faces_both_ways(std::span<const glm::vec3> positions, std::span<const std::uint32_t> indices,
                     const glm::vec3& eye);

/// The triangles by falling distance of their centroids from the eye, those of equal distance in their old order. Right
/// for tessellations of smooth surfaces, where triangles that cover each other are farther apart than they are large;
/// triangles that cut through each other have no order.
std::vector<std::uint32_t> back_to_front(std::span<const glm::vec3> positions, std::span<const std::uint32_t> indices,
                                         const glm::vec3& eye);

}  // namespace maquette
