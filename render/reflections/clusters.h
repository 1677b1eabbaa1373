#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

#include "render/scene_state/geometry.h"

namespace maquette {

/// Neighbouring triangles of one item, few enough for one workgroup to hold their vertices.
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
  std::vector<std::uint32_t> vertices;  ///< indices into the scene's vertices, cluster by cluster
  /// Of each triangle: indices of its corners within its cluster's vertices, 8 bits each; index in the scene.
  std::vector<glm::uvec2> triangles;
};

/// Clusters of all triangles; those of an item are sorted along a space-filling curve, whatever the order of the file.
ClusterSet make_clusters(const FlatGeometry& geometry);

/// Cluster of each triangle of the scene.
std::vector<std::uint32_t> cluster_of_triangle(const ClusterSet& set);

/// Triangle indices of the item, along the same curve.
std::vector<std::uint32_t> order_along_curve(const FlatGeometry& geometry, const DrawItem& item);

/// Rays that leave a small part of a mirror: origins in a sphere, directions in a cone.
struct Beam {
  glm::vec3 base{0.0f};
  float base_radius = 0.0f;
  glm::vec3 axis{0.0f, 0.0f, 1.0f};
  float sine = 0.0f, cosine = 1.0f;  ///< of the cone's half angle, at most 90 degrees
};
/// A small sphere and cone around the rays; directions unit.
Beam make_beam(std::span<const glm::vec3> origins, std::span<const glm::vec3> directions);
/// Conservative: false only when no ray of the beam meets the sphere.
inline bool may_meet(const Beam& beam, const glm::vec3& center, float radius) {
  if (beam.cosine <= 0.0f) return true;  // some rays may go in the opposite direction
  const glm::vec3 to = center - beam.base;
  const float along = glm::dot(to, beam.axis), reach = radius + beam.base_radius;
  if (along < -reach) return false;
  const float across2 = glm::dot(to, to) - along * along, limit = reach + along * beam.sine;
  // across cos - along sin is a lower bound of the distance to the cone
  return limit >= 0.0f && across2 * beam.cosine * beam.cosine <= limit * limit;
}

}  // namespace maquette
