#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <span>
#include <vector>

namespace maquette {

/// Vertices of a part in a local frame: centred, scaled to size 1, x and y along the sides of the smallest rectangle
/// around their projection.
struct Cloud {
  std::vector<glm::dvec3> points;
  std::vector<glm::dvec3> normals;      ///< unit or 0, as many; none where the mesh has none
  std::vector<std::uint32_t> vertices;  ///< indices into the mesh
  glm::dvec3 origin{0.0};
  glm::dmat3 world_from_local{1.0};
  double scale = 1.0;
};

/// Returns false for a part without area.
bool make_cloud(std::span<const glm::vec3> positions, std::span<const glm::vec3> normals,
                std::span<const std::uint32_t> indices, Cloud* cloud);

}  // namespace maquette
