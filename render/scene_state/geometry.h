#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "scenes/scene.h"

namespace maquette {

/// One instance of one primitive (or tessellated patch) in the flattened arrays.
struct DrawItem {
  int node = -1;
  int mesh = -1;       ///< -1 for a patch
  int primitive = -1;  ///< index in the mesh; -1 for a patch
  int patch = -1;
  std::uint32_t first_index = 0, index_count = 0;
  std::uint32_t first_vertex = 0, vertex_count = 0;
  float scale = 1.0f;  ///< of the node's transform: metres of the world in one of the mesh
};

/// All visible instances in world space with one shared index buffer (absolute indices). Attribute arrays have the
/// length of `positions`; missing normals are area-weighted means, missing tangents come from the UV set of the
/// normal texture (or any frame without UVs).
struct FlatGeometry {
  std::vector<glm::vec3> positions;  ///< metres
  std::vector<glm::vec3> normals;    ///< unit
  std::vector<glm::vec4> tangents;   ///< unit, w: handedness
  std::vector<glm::vec2> uv0, uv1;
  std::vector<glm::vec4> colors;  ///< 1 where the file has none
  std::vector<std::uint32_t> indices;
  std::vector<DrawItem> items;
};

/// The item that a triangle belongs to.
const DrawItem& item_of_triangle(const FlatGeometry& geometry, std::uint32_t triangle);

/// Whether the triangles of an item's node (of the item alone where it has none) have no border: each edge, by the
/// positions of its ends, is one of two triangles that pass it in opposite directions.
bool is_closed(const FlatGeometry& geometry, const DrawItem& item);

/// Flattens `scene`; patches are tessellated by their curvature. Triangles of a mirroring transform (negative
/// determinant) are rewound.
FlatGeometry flatten(const Scene& scene);

}  // namespace maquette
