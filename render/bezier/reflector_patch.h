#pragma once

#include <array>
#include <glm/glm.hpp>
#include <vector>

#include "render/bezier/bezier_shared.h"

namespace maquette {

/// A bicubic patch made ready for reflection: centred power basis about a point of it, in double and rounded to float.
struct ReflectorPatch {
  glm::dvec3 origin{0.0};  ///< world, m; coefficients, eyes and objects are relative to it
  bezier_double::BezierSurface exact{};
  bezier_float::BezierSurface single{};
  bool degenerate = false;   ///< no area: nothing can be reflected
  bool flat = false;         ///< within 1e-6 of its size of a plane: a mirrored eye serves better
  double convex_side = 0.0;  ///< 1: bulges to the side of dS/dx x dS/dy, -1: to the other; 0: neither or unknown
};

/// Control points [row v][column u] as BezierPatch has them, world space. x runs with u, y with v.
ReflectorPatch make_reflector_patch(const std::array<glm::dvec3, 16>& points);

/// The control points of the part between two parameters an axis, `within`: lower and upper, x before y, of [-1, 1].
std::array<glm::dvec3, 16> part_of_patch(const std::array<glm::dvec3, 16>& points, const glm::dvec4& within);

/// std140 twin of the one in shaders/reflections/reflectors.glsl.
struct PatchRecord {
  glm::vec4 origin{0.0f};
  glm::vec4 coefficients[16]{};
};
PatchRecord make_patch_record(const ReflectorPatch& patch);

/// The starting points of one patch for one eye and one of its sides.
struct ReflectorNodes {
  std::vector<bezier_float::BezierNode> nodes;
  float side = 1.0f;     ///< of dS/dx x dS/dy: what the eye sees
  bool careful = false;  ///< some node is seen from its back or nearly edge-on
  bool unique = false;   ///< the convex side: a reflection that is found is the only one
};

constexpr int kNodesPerSide = 5;

/// For the sides of the patch that the eye (relative to the patch's origin) sees at some node: none, one or two.
std::vector<ReflectorNodes> make_reflector_nodes(const ReflectorPatch& patch, const glm::dvec3& eye);

/// Start for one object, from all nodes.
bezier_float::BezierStart choose_start(const ReflectorNodes& nodes, const glm::vec3& eye, const glm::vec3& p);

}  // namespace maquette
