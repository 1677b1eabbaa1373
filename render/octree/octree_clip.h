#pragma once

#include <cstdint>
#include <functional>
#include <glm/glm.hpp>
#include <vector>

namespace maquette {

/// Convex polygon. Six clips of a triangle by axis planes give at most nine corners.
struct ClipPolygon {
  static constexpr int kMaxCorners = 12;
  glm::dvec3 corners[kMaxCorners]{};
  int count = 0;
};

/// Splits by the plane axis = value. A polygon that touches the plane without crossing it goes to one side; corners on
/// the plane count as above.
void split_polygon(const ClipPolygon& polygon, int axis, double value, ClipPolygon* below, ClipPolygon* above);
/// Half the sum of the cross products: its length is the area.
glm::dvec3 polygon_area_vector(const ClipPolygon& polygon);
/// Centroid by area; the mean of the corners where the area is 0.
glm::dvec3 polygon_centroid(const ClipPolygon& polygon);

/// Area of the plane through `point` inside the cube `lower`, `lower` + `size`; `normal`: of any length above 0.
double plane_section_area(const glm::dvec3& normal, const glm::dvec3& point, const glm::dvec3& lower, double size);

/// Clips a polygon exactly to the cells of a regular subdivision and emits the pieces with area.
class CellClipper {
 public:
  struct Piece {
    glm::ivec3 lower{0};  ///< of the cell, in finest cells
    int level = 0;
    const ClipPolygon* polygon = nullptr;
  };
  using IsLeaf = std::function<bool(const glm::ivec3& lower, int level)>;
  /// `depth` levels below a root of 2^depth finest cells; `is_leaf` ends the recursion early.
  CellClipper(int depth, const IsLeaf& is_leaf, const std::function<void(const Piece&)>& emit)
      : depth_(depth), is_leaf_(is_leaf), emit_(emit) {}
  /// Emits the parts of `polygon` (in finest cells) inside the cell `lower` of `level`.
  void clip(const ClipPolygon& polygon, const glm::ivec3& lower, int level) const;

 private:
  void descend(const ClipPolygon& polygon, const glm::ivec3& lower, int level) const;
  void descend_axis(const ClipPolygon& polygon, const glm::ivec3& lower, int level, int axis) const;
  int depth_;
  const IsLeaf& is_leaf_;
  const std::function<void(const Piece&)>& emit_;
};

}  // namespace maquette
