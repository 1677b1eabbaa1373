#pragma once

#include "render/octree/cell_brdf_bake.h"
#include "render/octree/octree_kind.h"

namespace maquette {

/// What the cell BRDFs of an octree are baked from, by value.
struct CellBrdfJob {
  OctreeJob octree;  ///< its path: of the octree's file
  std::shared_ptr<const OctreeBricks> bricks;
  std::vector<Material> materials;  ///< without the default one
  CellBrdfOptions options;
  std::shared_ptr<const CellBrdfs> before;  ///< what may be reused; null: what the file holds
};

/// Bakes what has changed since `before` or the file, and keeps the file up to date.
class CellBrdfKind : public FileBakeKind<CellBrdfJob, CellBrdfs> {
 public:
  Baked<CellBrdfs> load(const CellBrdfJob&) override;
  Baked<CellBrdfs> run(const CellBrdfJob&, const Baked<CellBrdfs>& kept, const BakeTask<CellBrdfs>&) override;
  std::chrono::seconds save_interval() const override { return std::chrono::seconds(30); }

 protected:
  BakePlace place(const CellBrdfJob&) const override;
  CellBrdfs read(const std::string& path) const override;
  void write(const std::string& path, const CellBrdfJob&, const CellBrdfs&, bool complete) const override;
};

/// The same on this thread. Null once `cancel` is set.
std::shared_ptr<const CellBrdfs> run_cell_brdf_job(const CellBrdfJob& job, const std::atomic<bool>& cancel,
                                                   const std::function<void(double)>& progress);

}  // namespace maquette
