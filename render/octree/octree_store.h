#pragma once

#include <memory>
#include <optional>

#include "render/octree/cell_brdf_buffers.h"
#include "render/octree/cell_brdf_worker.h"
#include "render/octree/octree_buffers.h"
#include "render/octree/octree_worker.h"

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

/// The octree of one scene on the GPU, and the worker that builds it.
class OctreeStore {
 public:
  /// Starts a build when `state` differs from the last one's, and uploads one that is done; until then the old one
  /// stays. `make_job` fills everything but `before`. True when what is drawn has changed. Throws what made a build
  /// fail, once.
  bool update(const OctreeState& state, const std::function<OctreeJob()>& make_job);
  /// The same for the BRDFs of its cells, once it is there: `content` is that of all materials, empty for none wanted.
  /// BRDFs of other materials, or of another octree, are dropped at once. `make_job` fills everything but `bricks` and
  /// `before`.
  bool update_cells(const std::vector<std::uint64_t>& content, const std::function<CellBrdfJob()>& make_job);
  const CellBrdfBuffers* cells() const { return cell_buffers_ ? &*cell_buffers_ : nullptr; }
  bool cells_busy() const { return cell_worker_ && cell_worker_->busy(); }
  double cells_progress() const { return cell_worker_ ? cell_worker_->progress() : 0.0; }
  std::size_t cell_bytes() const { return cell_buffers_ ? cell_buffers_->bytes() : 0; }
  void wait() {
    if (worker_) worker_->wait();
    if (cell_worker_) cell_worker_->wait();
  }
  /// Leaves of the finest level and of coarser ones.
  std::pair<std::size_t, std::size_t> leaf_counts() const { return leaf_counts_; }
  /// Another scene, or nothing needs it any more.
  void clear();
  bool ready() const { return buffers_.has_value(); }
  bool busy() const { return worker_ && worker_->busy(); }
  double progress() const { return worker_ ? worker_->progress() : 0.0; }
  const OctreeBuffers& buffers() const { return *buffers_; }
  std::size_t bytes() const { return buffers_ ? buffers_->bytes() : 0; }

 private:
  std::unique_ptr<OctreeWorker> worker_;
  std::shared_ptr<const OctreeBricks> bricks_;
  std::optional<OctreeState> asked_;
  std::optional<OctreeBuffers> buffers_;
  Octree levels_;  ///< without its nodes
  std::pair<std::size_t, std::size_t> leaf_counts_{0, 0};
  std::unique_ptr<CellBrdfWorker> cell_worker_;
  std::shared_ptr<const CellBrdfs> brdfs_;
  std::shared_ptr<const OctreeBricks> cells_asked_for_;
  std::vector<std::uint64_t> cells_content_;
  std::optional<CellBrdfBuffers> cell_buffers_;
};

}  // namespace maquette
