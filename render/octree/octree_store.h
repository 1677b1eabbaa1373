#pragma once

#include <memory>
#include <optional>

#include "render/octree/octree_buffers.h"
#include "render/octree/octree_worker.h"

namespace maquette {

/// What decides whether the octree on the GPU is still that of the scene.
struct OctreeState {
  std::uint32_t geometry_epoch = 0;
  std::vector<bool> transmits;
  std::vector<int> materials;
  int depth = 0;
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
  void wait() {
    if (worker_) worker_->wait();
  }
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
};

}  // namespace maquette
