#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "render/scene_state/geometry.h"
#include "scenes/btf/btf.h"

namespace maquette {

/// A point where light transfer is computed: a vertex of the drawn triangles or of their subdivision.
struct TransferVertex {
  glm::vec3 position{0.0f};  ///< m
  glm::vec3 n{0.0f}, t{0.0f}, b{0.0f};
  glm::vec3 inside{0.0f};  ///< towards the middle of a triangle around it, m: rays start a little that way
  std::uint32_t group = 0;
};

/// Items of one material.
struct TransferPart {
  std::size_t item = 0;
  std::uint32_t group = 0;
  float tiles_per_uv_x = 0.0f, tiles_per_uv_y = 0.0f;  ///< of its BTF; 0: it has no coordinates, and shows the mean
  int level = 0;                                       ///< its triangles are divided into 4^level, at least
};

/// Triangles of parts, each divided into 4^level flat ones, so that neighbours in an item share their vertices.
struct TransferMesh {
  struct Triangle {
    std::uint32_t source = 0;  ///< of the geometry
    std::uint32_t part = 0;
    std::uint32_t first = 0;  ///< in `grid`
    int level = 0;
  };
  std::vector<TransferPart> parts;
  std::vector<TransferVertex> vertices;
  std::vector<Triangle> triangles;
  /// Of a triangle, (n + 1)(n + 2) / 2 vertices for n = 2^level: rows j = 0 ... n of n + 1 - j, weights of the corners
  /// 1 - (i + j) / n, i / n, j / n.
  std::vector<std::uint32_t> grid;
};

inline constexpr int kMostTransferLevels = 6;

/// `wanted`: at least so many vertices, by dividing the triangles of the item with the longest edges; 0: those drawn.
/// Triangles without an area, and vertices of none, are left out.
TransferMesh make_transfer_mesh(const FlatGeometry& geometry, const std::vector<TransferPart>& parts,
                                std::size_t wanted);

/// Three vertices and their shares at a point of a triangle, `b`: weights of its second and third corner.
struct TransferCorners {
  std::uint32_t vertex[3] = {0, 0, 0};
  float share[3] = {1.0f, 0.0f, 0.0f};
};
TransferCorners find_transfer_corners(const TransferMesh& mesh, const TransferMesh::Triangle& triangle,
                                      const glm::vec2& b);

/// Metres along the square [0, 1]^2 of an item's texture coordinates: root of the ratio of areas; 0: it has none.
double metres_per_uv(const FlatGeometry& geometry, const DrawItem& item);

}  // namespace maquette
