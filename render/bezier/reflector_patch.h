#pragma once

#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "render/bezier/bezier_shared.h"

namespace maquette {

/// A bicubic patch prepared for reflection: power basis centred at a point of it, in double and rounded to float.
struct ReflectorPatch {
  glm::dvec3 origin{0.0};  ///< world, m; coefficients, eye and objects are relative to it
  bezier_double::BezierSurface exact{};
  bezier_float::BezierSurface single{};
  bool degenerate = false;   ///< no area: it reflects nothing
  bool flat = false;         ///< planar within 1e-6 of its size: reflecting the eye in the plane is better
  double convex_side = 0.0;  ///< 1: convex on the side of dS/dx x dS/dy, -1: on the other; 0: neither or unknown
};

/// `points`: control points [row v][column u] as in BezierPatch, world space. x grows with u, y with v.
ReflectorPatch make_reflector_patch(const std::array<glm::dvec3, 16>& points);

/// Control points of a sub-patch. `within`: lower and upper parameters, x before y, in [-1, 1].
std::array<glm::dvec3, 16> part_of_patch(const std::array<glm::dvec3, 16>& points, const glm::dvec4& within);

/// std140, as in shaders/reflections/reflectors.glsl.
struct PatchRecord {
  glm::vec4 origin{0.0f};
  glm::vec4 coefficients[16]{};
};
PatchRecord make_patch_record(const ReflectorPatch& patch);

/// Starting points of the search on one side of one patch, for one eye.
struct ReflectorNodes {
  std::vector<bezier_float::BezierNode> nodes;
  float side = 1.0f;     ///< 1 or -1: the side of dS/dx x dS/dy that the eye sees
  bool careful = false;  ///< some node is back-facing or nearly edge-on
  bool unique = false;   ///< convex side: a reflection point is unique
};

constexpr int kNodesPerSide = 5;

/// One entry for each side of the patch that the eye (relative to the patch's origin) sees: none, one or two.
std::vector<ReflectorNodes> make_reflector_nodes(const ReflectorPatch& patch, const glm::dvec3& eye);

/// The node from which the search for an object at `p` starts.
bezier_float::BezierStart best_start(const ReflectorNodes& nodes, const glm::vec3& eye, const glm::vec3& p);

}  // namespace maquette
