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
         depth == o.depth && path == o.path && same_boxes(interest, o.interest);
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
  return true;
}

void OctreeStore::clear() {
  worker_.reset();
  bricks_.reset();
  asked_.reset();
  buffers_.reset();
}

}  // namespace maquette
