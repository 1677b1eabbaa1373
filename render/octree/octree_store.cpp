#include "render/octree/octree_store.h"

namespace maquette {

namespace {

bool same_boxes(const std::vector<Bounds>& a, const std::vector<Bounds>& b) {
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i)
    if (a[i].min != b[i].min || a[i].max != b[i].max) return false;
  return true;
}

}  // namespace

bool OctreeState::operator==(const OctreeState& o) const {
  return geometry_epoch == o.geometry_epoch && transmits == o.transmits && materials == o.materials &&
         depth == o.depth && detail == o.detail && path == o.path && same_boxes(interest, o.interest);
}

bool OctreeStore::update(const OctreeState& state, const std::function<OctreeJob()>& make_job) {
  if (!worker_) worker_ = std::make_unique<OctreeWorker>();
  if (!asked_ || !(*asked_ == state)) {
    OctreeJob job = make_job();
    job.before = bricks_;
    worker_->submit(std::move(job));
    asked_ = state;
    return false;
  }
  auto result = worker_->take();
  if (!result) return false;
  bricks_ = result->bricks;
  buffers_.reset();  // both at once may not fit
  buffers_.emplace(result->octree);
  const Octree& octree = result->octree;
  const std::size_t finest = octree.empty() ? 0 : octree.leaf_count(octree.depth - octree.detail);
  leaf_counts_ = {finest, octree.empty() ? 0 : octree.leaf_count() - finest};
  levels_.depth = octree.depth;
  levels_.level_begin = octree.level_begin;
  cell_buffers_.reset();
  return true;
}

bool OctreeStore::update_cells(const std::vector<std::uint64_t>& content,
                               const std::function<CellBrdfJob()>& make_job) {
  if (content.empty() || !bricks_) {
    const bool changed = cell_buffers_.has_value();
    cell_buffers_.reset();
    cell_worker_.reset();
    cells_asked_for_.reset();
    return changed;
  }
  if (!cell_worker_) cell_worker_ = std::make_unique<CellBrdfWorker>();
  if (cells_asked_for_ != bricks_ || cells_content_ != content) {
    CellBrdfJob job = make_job();
    job.bricks = bricks_;
    job.before = brdfs_;
    cell_worker_->submit(std::move(job));
    cells_asked_for_ = bricks_;
    cells_content_ = content;
    const bool changed = cell_buffers_.has_value();
    cell_buffers_.reset();
    return changed;
  }
  auto result = cell_worker_->take();
  if (!result) return false;
  brdfs_ = std::make_shared<const CellBrdfs>(std::move(*result));
  cell_buffers_.emplace(index_cell_brdfs(*brdfs_, *bricks_, levels_), brdfs_->pca);
  return true;
}

void OctreeStore::clear() {
  worker_.reset();
  cell_worker_.reset();
  brdfs_.reset();
  cells_asked_for_.reset();
  cell_buffers_.reset();
  bricks_.reset();
  asked_.reset();
  buffers_.reset();
}

}  // namespace maquette
