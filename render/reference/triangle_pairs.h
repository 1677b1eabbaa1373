#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace maquette {

/// Triangles that share an edge, two by two: a ray tracer that takes each pair as one quad has half as much to read.
struct TrianglePairs {
  /// First the pairs, both triangles of one beside each other, then those without a partner.
  std::vector<std::uint32_t> order;
  std::uint32_t pair_count = 0;
};

/// Pairs neighbours among `triangles`, each at most once, where the box around both is little larger than theirs.
/// `indices`: three corners of every triangle; those of the pairs are turned (their winding stays) so that a pair is
/// (v0, v1, v3) and (v2, v3, v1) of the quad v0, v1, v2, v3. Time in proportion to the triangles and positions.
TrianglePairs pair_triangles(std::span<const std::uint32_t> triangles, std::span<const glm::vec3> positions,
                             std::span<std::uint32_t> indices);

}  // namespace maquette
