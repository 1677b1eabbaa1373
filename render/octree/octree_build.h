#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "render/octree/octree.h"
#include "render/octree/octree_brick.h"
#include "render/octree/octree_clip.h"
#include "render/octree/octree_textures.h"
#include "render/scene_state/geometry.h"

namespace maquette {

/// Inputs of an octree. References must outlive the call.
struct OctreeSource {
  const FlatGeometry& geometry;
  const std::vector<int>& materials;   ///< of each item
  const std::vector<bool>& transmits;  ///< of each item: panes and hidden items are left out
  const OctreeTextures& textures;
};

struct OctreeOptions {
  /// Levels of the core, which contains nearly all triangles (a car, not the ground under it): the finest cells are its
  /// widest side / 2^depth.
  int depth = 9;
  /// Regions with the finest cells; elsewhere in the core they are two levels coarser. Empty: the whole core.
  std::vector<Bounds> interest = {};
  /// Additional levels for cells that hold more detail than one normal and one colour.
  int detail = 0;
  std::size_t max_nodes = kOctreeMaxNodes;
};

/// The grid of an octree.
struct OctreeGrid {
  glm::dvec3 corner{0.0};  ///< of the root
  double side_m = 0.0;     ///< of the root; 0: empty
  int depth = 0;           ///< levels below the root of the finest cells
  int detail = 0;          ///< of these, levels that only detailed cells have
  int rest_depth = 0;      ///< levels below the root outside `fine`
  int brick_level = 0;     ///< level of the bricks: subtrees that are built, kept and reused separately
  Bounds core;
  std::vector<Bounds> fine;  ///< where cells are at `depth` - `detail` or finer; empty: everywhere
};
/// Computes the grid for these surfaces. `before` is kept while it still fits, so that a movement inside a scene does
/// not shift all cells.
OctreeGrid compute_octree_grid(const OctreeSource& source, const OctreeOptions& options, const OctreeGrid* before);

struct OctreeBricks {
  OctreeGrid grid;
  struct Entry {
    std::uint64_t key = 0;  ///< hash of all inputs
    OctreeBrick brick;
  };
  std::map<std::uint32_t, Entry> bricks;  ///< by Morton code; only bricks that are not empty
  std::size_t reused = 0;                 ///< bricks that were taken over from `before`
};

struct OctreeProgress {
  const std::atomic<bool>* cancel = nullptr;
  std::function<void(double)> report;                                       ///< in [0, 1], one thread at a time
  std::function<void(std::uint32_t, const OctreeBricks::Entry&)> finished;  ///< a new brick, one thread at a time
};

/// Builds the bricks that differ from `before` (null: all) in parallel; returns nothing when cancelled. Throws Error
/// when there are more nodes than `max_nodes`, naming the depth that fits, or more materials than a node can name.
std::optional<OctreeBricks> build_octree_bricks(const OctreeSource& source, const OctreeOptions& options,
                                                const OctreeBricks* before, const OctreeProgress& progress);
/// The piece of one triangle in one leaf.
struct OctreePiece {
  std::uint32_t code = 0;  ///< of the leaf, as OctreeFragment::code
  int material = 0;
  glm::vec3 color{1.0f};  ///< mean of texture and vertex colours; multiplies the material's own colour
  float opacity = 1.0f;
  ClipPolygon polygon;  ///< in finest cells from the root's corner
};

/// The scene split along the leaves of a grid, brick by brick, as input of bakes of cells. The source must outlive it.
class OctreePieces {
 public:
  OctreePieces(const OctreeSource& source, const OctreeGrid& grid);
  ~OctreePieces();
  OctreePieces(const OctreePieces&) = delete;
  OctreePieces& operator=(const OctreePieces&) = delete;
  /// The pieces of a brick, in the order of the leaves. May be called from several threads.
  std::vector<OctreePiece> of_brick(std::uint32_t code) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Joins the bricks below a common top.
Octree assemble_octree(const OctreeBricks& bricks);
/// Builds and assembles an octree from nothing.
Octree build_octree(const OctreeSource& source, const OctreeOptions& options);

}  // namespace maquette
