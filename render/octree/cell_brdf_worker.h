#pragma once

#include "render/background_worker.h"
#include "render/octree/cell_brdf_bake.h"
#include "render/octree/octree_worker.h"

namespace maquette {

/// What the cell BRDFs of an octree are baked from, by value.
struct CellBrdfJob {
  OctreeJob octree;  ///< its path: of the octree's file
  std::shared_ptr<const OctreeBricks> bricks;
  std::vector<Material> materials;  ///< without the default one
  CellBrdfOptions options;
  std::shared_ptr<const CellBrdfs> before;  ///< what may be reused; null: what the file holds
};

/// Bakes what has changed since `before` or the file, and keeps the file up to date, so that an interrupted bake
/// resumes. Nothing once `cancel` is set.
std::optional<CellBrdfs> run_cell_brdf_job(const CellBrdfJob& job, const std::atomic<bool>& cancel,
                                           const std::function<void(double)>& progress);

class CellBrdfWorker : public BackgroundWorker<CellBrdfJob, CellBrdfs> {
 public:
  CellBrdfWorker() : BackgroundWorker(run_cell_brdf_job) {}
};

}  // namespace maquette
