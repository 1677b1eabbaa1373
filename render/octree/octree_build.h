#pragma once

#include <atomic>
#include <cstdint>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "render/geometry.h"
#include "render/octree/octree.h"
#include "render/octree/octree_brick.h"
#include "render/octree/octree_clip.h"
#include "render/octree/octree_paint.h"

namespace maquette {

/// What goes into an octree. References must outlive the call.
struct OctreeSource {
  const FlatGeometry& geometry;
  const std::vector<int>& materials;   ///< of each item
  const std::vector<bool>& transmits;  ///< of each item: panes and what is hidden are left out
  const OctreePaint& paint;
};

struct OctreeOptions {
  /// Cells are the core's widest side / 2^depth; the core holds nearly all triangles (a car, not the ground it stands
  /// on).
  int depth = 9;
  /// Where cells are that fine; two levels coarser in the rest of the core. Empty: the whole core.
  std::vector<Bounds> interest = {};
  /// So many levels finer are cells that hold more than one normal and one colour can say.
  int detail = 0;
  std::size_t max_nodes = kOctreeMaxNodes;
};

/// The grid of an octree.
struct OctreeGrid {
  glm::dvec3 corner{0.0};  ///< of the root
  double side_m = 0.0;     ///< of the root; 0: nothing to hold
  int depth = 0;           ///< levels below the root of the finest cells
  int detail = 0;          ///< of them, levels that only cells of much detail have
  int rest_depth = 0;      ///< levels below the root elsewhere
  int brick_level = 0;     ///< level of the subtrees that are built, kept and reused on their own
  Bounds core;
  std::vector<Bounds> fine;  ///< where cells are at `depth` - `detail` or finer; empty: everywhere
};
/// The grid for these surfaces. `before` is taken over while it still fits, so that what moves inside a scene does not
/// shift all cells.
OctreeGrid choose_octree_grid(const OctreeSource& source, const OctreeOptions& options, const OctreeGrid* before);

struct OctreeBricks {
  OctreeGrid grid;
  struct Entry {
    std::uint64_t key = 0;  ///< hash of all that it was made from
    OctreeBrick brick;
  };
  std::map<std::uint32_t, Entry> bricks;  ///< by Morton code; only those that hold something
  std::size_t reused = 0;                 ///< how many came from the bricks before
};

struct OctreeProgress {
  const std::atomic<bool>* cancel = nullptr;
  std::function<void(double)> report;                                       ///< in [0, 1], one thread at a time
  std::function<void(std::uint32_t, const OctreeBricks::Entry&)> finished;  ///< a new brick, one thread at a time
};

/// Builds what differs from `before` (null: everything) on all cores; nothing when cancelled. Throws Error when there
/// are more nodes than `max_nodes`, naming the depth that fits, or more materials than a node can name.
std::optional<OctreeBricks> build_octree_bricks(const OctreeSource& source, const OctreeOptions& options,
                                                const OctreeBricks* before, const OctreeProgress& progress);
/// What one triangle has in one leaf.
struct OctreePiece {
  std::uint32_t code = 0;  ///< of the leaf, as OctreeFragment::code
  int material = 0;
  glm::vec3 color{1.0f};  ///< mean of texture and vertices; multiplies the material's own
  float opacity = 1.0f;
  ClipPolygon polygon;  ///< in finest cells from the root's corner
};

/// The scene cut along the leaves of a grid, brick by brick: what bakes of cells are made from. The source must outlive
/// it.
class OctreePieces {
 public:
  OctreePieces(const OctreeSource& source, const OctreeGrid& grid);
  ~OctreePieces();
  OctreePieces(const OctreePieces&) = delete;
  OctreePieces& operator=(const OctreePieces&) = delete;
  /// In the order of the leaves. May be called from several threads.
  std::vector<OctreePiece> of_brick(std::uint32_t code) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

/// Joins the bricks below a common top.
Octree assemble_octree(const OctreeBricks& bricks);
/// Both, without a past.
Octree build_octree(const OctreeSource& source, const OctreeOptions& options);

}  // namespace maquette
