#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace maquette {

/// Whether the eye sees the front of some triangles and the back of others: such a surface may occlude itself.
/// `indices`: three a triangle; `eye` in the space of `positions`.
bool faces_both_ways(std::span<const glm::vec3> positions, std::span<const std::uint32_t> indices,
                     const glm::vec3& eye);

/// The triangles sorted by falling distance of their centroids from the eye; equal distances keep their order. Correct
/// for tessellations of smooth surfaces, where triangles that occlude each other are farther apart than they are large;
/// triangles that intersect have no order.
std::vector<std::uint32_t> back_to_front(std::span<const glm::vec3> positions, std::span<const std::uint32_t> indices,
                                         const glm::vec3& eye);

}  // namespace maquette
