#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "render/octree/cell_brdf.h"

namespace maquette::test {

/// Polygons inside a cube from (0, 0, 0) to (1, 1, 1), each with its material.
struct CellContent {
  std::vector<ClipPolygon> polygons;
  std::vector<CellReflectance> reflectance;
};

/// A rectangle by a corner and two edges.
ClipPolygon rectangle(const glm::dvec3& corner, const glm::dvec3& u, const glm::dvec3& v);

/// C(v) and E(v, l) of a cell as a distant eye sees it: `side`^2 parallel rays over its outline, each tested against
/// every polygon, and a shadow ray from each hit to each light. Slow, in double.
struct CellView {
  double seen = 0.0;            ///< C(v)
  std::vector<glm::dvec3> lit;  ///< E(v, lights[i])
};
CellView compute_cell_view(const CellContent& content, const glm::dvec3& view, const std::vector<glm::dvec3>& lights,
                           int side);

/// The same by the product's own method: samples of the surface.
Eigen::VectorXf bake_content(const CellContent& content, const glm::vec3& normal, int samples);

}  // namespace maquette::test
