#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "render/frame/frame_constants.h"
#include "render/reflections/clusters.h"
#include "render/reflections/reflector_technique.h"
#include "render/triangle/triangle_mirror.h"

namespace maquette {

/// One triangle of a reflector for the eye of this frame.
struct Facet {
  mirror::TriangleMirror mirror{};
  Beam beam;
  /// Sides of the mirrored frustum, one along each edge: p is outside where
  /// dot(side, (p, 1)) > widening |p - beam.base|.
  glm::vec4 sides[3]{};
  glm::vec3 widening{0.0f};
  glm::vec4 box{-1.0f, -1.0f, 1.0f, 1.0f};  ///< on screen: lower and upper corner, -1 to 1
  /// Largest difference between the rays of the true surface and of the triangle, as the eye sees it, and the same in
  /// barycentrics.
  float margin_px = 1.0f, margin = 1.0f;
  float longest_px = 1e6f;  ///< longest edge on screen
  std::size_t reflector = 0;
  GhostDeviation ghost;
};

/// Conservative: false only when no ray of the facet meets the sphere.
bool may_meet(const Facet& facet, const glm::vec3& center, float radius);

/// The triangles of a curved reflector that may be visible: of a patch `side` x `side` quads, of a mesh its own.
/// `ghost`: largest difference of their rays from those of the front surface.
std::vector<Facet> make_facets(const Reflector& reflector, std::size_t number, const FlatGeometry& geometry,
                               const FrameConstants& frame, int side, const GhostDeviation& ghost);

}  // namespace maquette
