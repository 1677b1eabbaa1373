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
  require(state, [&] {
    OctreeJob job = make_job();
    job.before = bricks_;
    return job;
  });
  const std::shared_ptr<const OctreeResult> result = take();
  if (!result) return false;
  bricks_ = result->bricks;
  buffers_.reset();  // both at once may not fit
  buffers_.emplace(result->octree);
  const Octree& octree = result->octree;
  const std::size_t finest = octree.empty() ? 0 : octree.leaf_count(octree.depth - octree.detail);
  leaf_counts_ = {finest, octree.empty() ? 0 : octree.leaf_count() - finest};
  levels_.depth = octree.depth;
  levels_.level_begin = octree.level_begin;
  cells_.release();
  return true;
}

bool OctreeStore::update_cells(const std::vector<std::uint64_t>& content,
                               const std::function<CellBrdfJob()>& make_job) {
  if (!content.empty() && bricks_) return cells_.update({bricks_, content}, levels_, make_job);
  cells_.cancel();
  return cells_.release();
}

void OctreeStore::clear() {
  cancel();
  cells_.clear();
  bricks_.reset();
  buffers_.reset();
}

bool CellBrdfStore::update(const CellBrdfState& state, const Octree& levels,
                           const std::function<CellBrdfJob()>& make_job) {
  const bool started = require(state, [&] {
    CellBrdfJob job = make_job();
    job.bricks = state.bricks;
    job.before = brdfs_;
    return job;
  });
  const bool released = started && release();
  const std::shared_ptr<const CellBrdfs> brdfs = take();
  if (!brdfs) return released;
  brdfs_ = brdfs;
  buffers_.emplace(index_cell_brdfs(*brdfs_, *state.bricks, levels), brdfs_->pca);
  return true;
}

bool CellBrdfStore::release() {
  const bool drawn = ready();
  buffers_.reset();
  return drawn;
}

void CellBrdfStore::clear() {
  cancel();
  brdfs_.reset();
  buffers_.reset();
}

}  // namespace maquette
