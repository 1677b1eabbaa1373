#pragma once

#include <memory>
#include <optional>

#include "render/bake/bake_runner.h"
#include "render/octree/cell_brdf_buffers.h"
#include "render/octree/cell_brdf_kind.h"
#include "render/octree/octree_buffers.h"
#include "render/octree/octree_kind.h"

namespace maquette {

/// What decides whether the octree on the GPU is still that of the scene.
struct OctreeState {
  std::uint32_t geometry_epoch = 0;
  std::vector<bool> transmits;
  std::vector<int> materials;
  int depth = 0, detail = 0;
  std::vector<Bounds> interest;
  std::string path;
  bool operator==(const OctreeState&) const;
};

/// What decides whether the BRDFs of an octree's cells are still those of the scene.
struct CellBrdfState {
  std::shared_ptr<const OctreeBricks> bricks;
  std::vector<std::uint64_t> content;  ///< of all materials
  bool operator==(const CellBrdfState&) const = default;
};

/// The BRDFs of an octree's cells on the GPU.
class CellBrdfStore final : public KeyedBake<CellBrdfState, CellBrdfJob, CellBrdfs> {
 public:
  CellBrdfStore() : KeyedBake(std::make_shared<CellBrdfKind>()) {}
  const char* name() const override { return "cell_brdfs"; }
  /// As OctreeStore::update_cells. `levels`: of the octree, without its nodes.
  bool update(const CellBrdfState& state, const Octree& levels, const std::function<CellBrdfJob()>& make_job);
  /// They are not drawn with any more; what may be reused stays. True when they were.
  bool release();
  void clear();
  bool ready() const override { return buffers_.has_value(); }
  const CellBrdfBuffers* buffers() const { return buffers_ ? &*buffers_ : nullptr; }
  std::size_t bytes() const override { return buffers_ ? buffers_->bytes() : 0; }

 private:
  std::shared_ptr<const CellBrdfs> brdfs_;
  std::optional<CellBrdfBuffers> buffers_;
};

/// The octree of one scene on the GPU, and the BRDFs of its cells.
class OctreeStore final : public KeyedBake<OctreeState, OctreeJob, OctreeResult> {
 public:
  OctreeStore() : KeyedBake(std::make_shared<OctreeKind>()) {}
  const char* name() const override { return "octree"; }
  /// Starts a build when `state` differs from the last one's, and uploads one that is done; until then the old one
  /// stays. `make_job` fills everything but `before`. True when what is drawn has changed. Throws what made a build
  /// fail, once.
  bool update(const OctreeState& state, const std::function<OctreeJob()>& make_job);
  /// The same for the BRDFs of its cells, once it is there: `content` is that of all materials, empty for none wanted.
  /// BRDFs of other materials, or of another octree, are dropped at once. `make_job` fills everything but `bricks` and
  /// `before`.
  bool update_cells(const std::vector<std::uint64_t>& content, const std::function<CellBrdfJob()>& make_job);
  const CellBrdfStore& cell_bake() const { return cells_; }
  CellBrdfStore& cell_bake() { return cells_; }
  const CellBrdfBuffers* cells() const { return cells_.buffers(); }
  double cells_progress() const { return cells_.progress(); }
  std::size_t cell_bytes() const { return cells_.bytes(); }
  /// For the BRDFs of its cells too.
  void wait() override {
    KeyedBake::wait();
    cells_.wait();
  }
  /// Leaves of the finest level and of coarser ones.
  std::pair<std::size_t, std::size_t> leaf_counts() const { return leaf_counts_; }
  /// Another scene, or nothing needs it any more.
  void clear();
  bool ready() const override { return buffers_.has_value(); }
  const OctreeBuffers& buffers() const { return *buffers_; }
  std::size_t bytes() const override { return buffers_ ? buffers_->bytes() : 0; }

 private:
  std::shared_ptr<const OctreeBricks> bricks_;
  std::optional<OctreeBuffers> buffers_;
  Octree levels_;  ///< without its nodes
  std::pair<std::size_t, std::size_t> leaf_counts_{0, 0};
  CellBrdfStore cells_;
};

}  // namespace maquette
