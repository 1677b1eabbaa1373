#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace maquette {

/// What one clipped piece of a triangle brings to its cell. Lengths in finest cells.
struct OctreeFragment {
  std::uint32_t code = 0;  ///< Morton code of its cell inside the brick, left-aligned to the finest level
  int level = 0;
  std::uint32_t material = 0;
  std::uint32_t triangle = 0, item = 0;  ///< of the geometry
  float area = 0.0f;
  std::uint32_t first_corner = 0, corner_count = 0;  ///< of OctreeFragments::corners
  float opacity = 1.0f;                              ///< share that is not cut out
  glm::vec3 normal{0.0f};                            ///< unit, of the surface (interpolated)
  glm::vec3 geometric{0.0f};                         ///< unit, of the triangle
  glm::vec3 centroid{0.0f};                          ///< from the brick's lower corner
  glm::vec3 color{1.0f};
};

/// The pieces of a brick.
struct OctreeFragments {
  std::vector<OctreeFragment> pieces;
  std::vector<glm::vec3> corners;  ///< from the brick's lower corner
};

/// Sums over what a node holds, in finest cells from the brick's (later the root's) lower corner.
struct OctreeSums {
  static constexpr int kMaterials = 4;
  double area = 0.0;         ///< of what is not cut out
  glm::dvec3 normal{0.0};    ///< area-weighted
  glm::dvec3 centroid{0.0};  ///< area-weighted
  /// Largest areas by material, of what is seen along the normal; leaves are exact, and a node above keeps the four
  /// largest of its children's.
  std::array<double, kMaterials> material_area{};
  std::array<std::uint32_t, kMaterials> material{};
  std::array<glm::dvec3, kMaterials> material_color{};  ///< weighted by those areas
  std::array<std::uint32_t, kMaterials> triangle{};     ///< that brings most of that area
  /// Distance from the node's plane that all of its surface keeps; above kOctreePlanar the node is a solid box.
  double deviation = 0.0;
  /// How far it reaches along the unit normal, from the centroid, in its cells.
  double low = 0.0, high = 0.0;

  void add_material(std::uint32_t id, double amount, const glm::dvec3& color, std::uint32_t of_triangle);
};

/// Words of a node for the GPU (shaders/shared/octree.glsl).
struct OctreeWords {
  std::uint32_t plane = 0, color = 0;
  std::uint32_t triangle = 0;  ///< of the geometry, that stands for the node: what is baked by vertex is known there
};

/// The nodes of one brick, by level from its root; within a level in Morton order.
struct OctreeBrick {
  std::vector<std::uint8_t> masks;    ///< child masks; 0 for leaves
  std::vector<OctreeWords> words;     ///< same length
  std::vector<std::uint32_t> counts;  ///< nodes of each level; empty where nothing is
  OctreeSums sums;                    ///< of its root
};

/// Cells of a level are `cell` finest cells wide; `lower` of the node in the same frame as the sums.
OctreeWords pack_node(const OctreeSums& sums, const glm::dvec3& lower, double cell);

/// Builds a brick of `levels` levels below its root from its fragments (any order; they are sorted).
OctreeBrick build_brick(OctreeFragments* fragments, int levels);

/// Joins the sums of up to eight children (null where there is none), whose cells are `child_cell` wide.
OctreeSums join_children(const std::array<const OctreeSums*, 8>& children, double child_cell);

}  // namespace maquette
