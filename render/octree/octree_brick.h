#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace maquette {

/// One piece of a triangle after clipping to a cell. Lengths in finest cells.
struct OctreeFragment {
  std::uint32_t code = 0;  ///< Morton code of its cell inside the brick, left-aligned to the finest level
  int level = 0;
  std::uint32_t material = 0;
  std::uint32_t triangle = 0, item = 0;  ///< of the geometry
  float area = 0.0f;
  std::uint32_t first_corner = 0, corner_count = 0;  ///< of OctreeFragments::corners
  float opacity = 1.0f;                              ///< share that is not cut out
  glm::vec3 normal{0.0f};                            ///< unit, interpolated from the vertices
  glm::vec3 geometric{0.0f};                         ///< unit, of the triangle
  glm::vec3 centroid{0.0f};                          ///< from the brick's lower corner
  glm::vec3 color{1.0f};
};

/// All pieces of a brick.
struct OctreeFragments {
  std::vector<OctreeFragment> pieces;
  std::vector<glm::vec3> corners;  ///< from the brick's lower corner
};

/// Sums over the surface inside a node, in finest cells from the brick's (later the root's) lower corner.
struct OctreeSums {
  static constexpr int kMaterials = 4;
  double area = 0.0;         ///< without what is cut out
  glm::dvec3 normal{0.0};    ///< area-weighted
  glm::dvec3 centroid{0.0};  ///< area-weighted
  /// The largest areas by material, as seen along the normal; exact for leaves, while a node above keeps the four
  /// largest of its children.
  std::array<double, kMaterials> material_area{};
  std::array<std::uint32_t, kMaterials> material{};
  std::array<glm::dvec3, kMaterials> material_color{};  ///< weighted by those areas
  std::array<std::uint32_t, kMaterials> triangle{};     ///< triangle with the largest part of that area
  /// Largest distance of the surface from the node's plane; above kOctreePlanar the node is a solid box.
  double deviation = 0.0;
  /// Extent along the unit normal, from the centroid, in the node's own cells.
  double low = 0.0, high = 0.0;

  void add_material(std::uint32_t id, double amount, const glm::dvec3& color, std::uint32_t of_triangle);
};

/// Words of a node for the GPU (shaders/shared/octree.glsl).
struct OctreeWords {
  std::uint32_t plane = 0, color = 0;
  std::uint32_t triangle = 0;  ///< represents the node, to look up data that is baked per vertex
};

/// The nodes of one brick, level by level from its root; within a level in Morton order.
struct OctreeBrick {
  std::vector<std::uint8_t> masks;    ///< child masks; 0 for leaves
  std::vector<OctreeWords> words;     ///< same length
  std::vector<std::uint32_t> counts;  ///< nodes of each level; empty for an empty brick
  OctreeSums sums;                    ///< of its root
};

/// Cells of the node's level are `cell` finest cells wide; `lower` of the node in the same frame as the sums.
OctreeWords pack_node(const OctreeSums& sums, const glm::dvec3& lower, double cell);

/// Builds a brick of `levels` levels below its root from its fragments (in any order; sorted here).
OctreeBrick build_brick(OctreeFragments* fragments, int levels);

/// Joins the sums of up to eight children (null where there is none), whose cells are `child_cell` wide.
OctreeSums join_children(const std::array<const OctreeSums*, 8>& children, double child_cell);

}  // namespace maquette
