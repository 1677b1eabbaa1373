#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace maquette {

/// Pairs of triangles with a common edge: a ray tracer that takes each pair as one quad reads half as much.
struct TrianglePairs {
  /// First the pairs, the two triangles of each adjacent, then the unpaired triangles.
  std::vector<std::uint32_t> order;
  std::uint32_t pair_count = 0;
};

/// Pairs neighbours among `triangles`, each at most once, where the box around both is little larger than their own
/// boxes. `indices`: three corners of every triangle; the corners of paired triangles are rotated (keeping their
/// winding) so that a pair is (v0, v1, v3) and (v2, v3, v1) of the quad v0, v1, v2, v3. Time is linear in the number of
/// triangles and positions.
TrianglePairs pair_triangles(std::span<const std::uint32_t> triangles, std::span<const glm::vec3> positions,
                             std::span<std::uint32_t> indices);

}  // namespace maquette
