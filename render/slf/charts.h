#pragma once

#include "render/slf/atlas.h"

namespace maquette {

/// A piece of surface laid into a plane.
struct Chart {
  std::vector<AtlasSide> sides;  ///< `at` in metres of the plane, from 0
  glm::dvec3 axis{0.0, 1.0, 0.0};
  glm::dvec2 extent{0.0};  ///< m
};

/// A triangle of a part, by side, with what charts are decided from.
struct ChartTriangle {
  std::uint32_t triangle = 0;
  bool back = false;
  std::array<glm::dvec3, 3> corners{};
  std::array<glm::dvec3, 3> normals{};  ///< of the shading
  glm::dvec3 normal{0.0};               ///< of the plane, on this side, unit
  double area = 0.0;                    ///< m2
  std::array<std::uint32_t, 3> vertices{};
};

/// Triangles of a part that have area, of one side of it.
std::vector<ChartTriangle> chart_triangles(const FlatGeometry& geometry, const DrawItem& item, bool back);

/// Charts of the second UV set, which is valid: its connected pieces, each scaled to its area.
std::vector<Chart> charts_of_uvs(const FlatGeometry& geometry, const std::vector<ChartTriangle>& triangles);

/// Charts within cones of normals, projected along their mean normals. They do not overlap themselves.
std::vector<Chart> charts_of_cones(const std::vector<ChartTriangle>& triangles);

/// Whether triangles of a plane cover each other, judged at the cells of a raster.
bool overlaps_itself(const std::vector<std::array<glm::dvec2, 3>>& triangles);

}  // namespace maquette
