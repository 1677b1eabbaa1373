#pragma once

#include "scenes/scene.h"

namespace maquette {

/// Catmull-Clark limit surface of a cage (OpenSubdiv): limit positions, limit normals, UVs and triangles after
/// `cage.levels` uniform refinements; `curvatures` (1/m, larger principal magnitude) on request. The stencil tables
/// only depend on the topology: keep the evaluator to move control points each frame.
class SubdivisionEvaluator {
 public:
  explicit SubdivisionEvaluator(const SubdivisionCage& cage);
  ~SubdivisionEvaluator();
  SubdivisionEvaluator(SubdivisionEvaluator&&) noexcept;
  SubdivisionEvaluator& operator=(SubdivisionEvaluator&&) noexcept;

  /// Positions and normals of the limit surface for these control points (same count as the cage's).
  void evaluate(const std::vector<glm::vec3>& control_points, std::vector<glm::vec3>* positions,
                std::vector<glm::vec3>* normals, std::vector<float>* curvatures = nullptr) const;
  /// Static part: indices and UVs, same order as evaluate()'s vertices.
  const std::vector<std::uint32_t>& indices() const;
  const std::vector<glm::vec2>& uvs() const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Fills mesh.primitives[0] geometry from mesh.cage.
void tessellate_cage(Mesh* mesh);
/// Moves every control point within `radius_m` of `center` along `direction` by depth_m * smooth falloff (C2, 1 at the
/// centre, 0 at the radius). Returns the number of points moved. Used by the mouse and by `render --dent`.
int dent_cage(SubdivisionCage* cage, const glm::vec3& center, const glm::vec3& direction, float depth_m,
              float radius_m);

/// Number of quads along u and along v.
struct PatchSides {
  int u = 1, v = 1;
};
/// From 16 to 128 each, so that neighbouring normals and edges differ by 0.006 rad: fewer would be visible along the
/// outline of a pane, where single triangles become front or back faces.
PatchSides patch_sides(const BezierPatch& patch);
/// Regular triangulation of a bicubic patch with exact normals.
Primitive tessellate_patch(const BezierPatch& patch, const PatchSides& sides);
inline Primitive tessellate_patch(const BezierPatch& patch, int n) { return tessellate_patch(patch, {n, n}); }

}  // namespace maquette
