#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "render/scene_state/geometry.h"

namespace maquette {

/// A point of an item's surface: one position and normal, shared by the vertices that agree in both bit by bit (texture
/// seams). Items stay separate: two floors that meet under a wall see different halves. Lengths are in units of
/// VisibilityPoints::scale_m around VisibilityPoints::center.
struct VisibilityPoint {
  glm::vec3 position{0.0f};
  glm::vec3 normal{0.0f, 1.0f, 0.0f};  ///< unit
  /// Offset from the vertex into its own triangles, along the tangent plane. For an edge that touches another surface
  /// (the foot of a wall, a joint of two boxes) the visible side then depends on the side of its own panel, not on
  /// rounding.
  glm::vec3 inset{0.0f};
  /// Offset along +n or -n: above the rounding error, and above the vertex's own triangles within the inset.
  float lift = 0.0f;
  /// Cells with n.c above minus this belong to the side of +n: between this vertex and its neighbours a convex smooth
  /// surface sees a little below this vertex's horizon. 0 on flat and concave surfaces.
  float horizon_slack = 0.0f;
};

inline constexpr std::uint32_t kNoPoint = 0xffffffffu;

/// The surface, welded and scaled to the unit sphere (rays in float keep their accuracy at any scene scale).
struct VisibilityPoints {
  std::vector<VisibilityPoint> points;
  std::vector<std::uint32_t> point_of_vertex;           ///< kNoPoint: in no triangle, or not finite
  std::vector<std::array<std::uint32_t, 3>> triangles;  ///< indices of points; only items that do not transmit
  glm::dvec3 center{0.0};                               ///< m
  double scale_m = 1.0;
};

/// Triangles with equal, out-of-range or non-finite corners are left out. Once `cancel` is set the result is incomplete
/// and must not be used.
VisibilityPoints build_visibility_points(const FlatGeometry& geometry, const std::vector<bool>& transmits,
                                         const std::atomic<bool>& cancel);

using VisibilityBits = std::array<std::uint32_t, 8>;

/// Variation of visibility per point, cycles/m.
///
/// F(edge): the share of one side's hemisphere, weighted by cosine, whose bits differ between the ends of an edge.
/// (Cells on opposite sides of the two tangent planes are curvature, not visibility, and do not count.) A wave of full
/// contrast changes by 2 per cycle, so a mean change per metre of g is g / 2 cycles/m; edges of random orientation see
/// 2 / pi of the gradient:
///   nu = (pi / 4) sum F / sum (length + scale_m / 16384),
/// over the edges at a point, followed by two rounds of averaging, half with the neighbours; the result is the larger
/// value of both sides. The added length keeps tiny edges finite (one flipped bit is 1/128 of the hemisphere).
std::vector<float> compute_visibility_bandwidth(const VisibilityPoints& points,
                                                const std::vector<VisibilityBits>& bits);

}  // namespace maquette
