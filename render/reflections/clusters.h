#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "render/geometry.h"

namespace maquette {

/// Neighbouring triangles of one item, few enough that one workgroup holds their vertices.
struct Cluster {
  static constexpr std::uint32_t kMaxVertices = 64, kMaxTriangles = 128;
  glm::vec3 center{0.0f};
  float radius = 0.0f;
  glm::vec3 half_extent{0.0f};                           ///< of its box, about the center
  std::uint32_t first_vertex = 0, vertex_count = 0;      ///< in ClusterSet::vertices
  std::uint32_t first_triangle = 0, triangle_count = 0;  ///< in ClusterSet::triangles
};

struct ClusterSet {
  struct Range {
    std::size_t begin = 0, end = 0;
  };
  std::vector<Cluster> clusters;
  std::vector<Range> of_item;
  std::vector<std::uint32_t> vertices;  ///< of each cluster, of the scene
  /// Of each: numbers of its corners in its cluster's vertices, 8 bits each; number in the scene.
  std::vector<glm::uvec2> triangles;
};

/// All triangles; those of an item along a curve that keeps neighbours together, whatever the order of the file.
ClusterSet make_clusters(const FlatGeometry& geometry);

/// Of each triangle of the scene the number of its cluster.
std::vector<std::uint32_t> cluster_of_triangle(const ClusterSet& set);

/// Numbers of the item's triangles, along the same curve.
std::vector<std::uint32_t> order_along_curve(const FlatGeometry& geometry, const DrawItem& item);

/// Rays that leave a small part of a mirror: origins in a sphere, directions in a cone.
struct Beam {
  glm::vec3 base{0.0f};
  float base_radius = 0.0f;
  glm::vec3 axis{0.0f, 0.0f, 1.0f};
  float sine = 0.0f, cosine = 1.0f;  ///< of the cone's half angle, at most 90 degrees
};
/// The smallest cone and sphere around some rays; directions unit.
Beam make_beam(std::span<const glm::vec3> origins, std::span<const glm::vec3> directions);
/// False only when no ray of the beam meets the sphere.
inline bool may_meet(const Beam& beam, const glm::vec3& center, float radius) {
  if (beam.cosine <= 0.0f) return true;  // some rays may go the other way
  const glm::vec3 to = center - beam.base;
  const float along = glm::dot(to, beam.axis), reach = radius + beam.base_radius;
  if (along < -reach) return false;
  const float across2 = glm::dot(to, to) - along * along, limit = reach + along * beam.sine;
  // across cos - along sin is at most the distance to the cone
  return limit >= 0.0f && across2 * beam.cosine * beam.cosine <= limit * limit;
}

}  // namespace maquette
