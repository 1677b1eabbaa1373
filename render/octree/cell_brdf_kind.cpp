#include "render/octree/cell_brdf_kind.h"

namespace maquette {

Baked<CellBrdfs> CellBrdfKind::load(const CellBrdfJob& job) {
  if (!job.before) return FileBakeKind::load(job);
  return {job.before, false, true};
}

Baked<CellBrdfs> CellBrdfKind::run(const CellBrdfJob& job, const Baked<CellBrdfs>& kept,
                                   const BakeTask<CellBrdfs>& task) {
  const CellBrdfs* before = kept.value.get();
  const OctreeJob& o = job.octree;
  const OctreeSource source{o.geometry, o.materials, o.transmits, *o.textures};
  CellTables tables;
  const std::vector<CellMaterial> materials = make_cell_materials(job.materials, &tables);
  // What an interrupted bake leaves: the bricks before, replaced by new ones as they come.
  CellBrdfs part = before ? *before : CellBrdfs{};
  bool changed = false;
  const CellBrdfProgress watch{&task.cancel, task.progress,
                               [&](const CellBrdfs& whole, std::uint32_t code, const CellBrdfs::Brick& brick) {
                                 if (!changed) part.pca = whole.pca, part.fit_loss = whole.fit_loss;
                                 changed = true;
                                 part.bricks[code] = brick;
                                 task.publish(part);
                               },
                               [&] {
                                 part = {};
                                 changed = false;
                               }};
  auto brdfs = bake_cell_brdfs({source, *job.bricks, materials}, job.options, before, watch);
  if (!brdfs)
    return changed ? Baked<CellBrdfs>{std::make_shared<const CellBrdfs>(std::move(part))} : Baked<CellBrdfs>{};
  const bool saved = !changed && before && before->bricks.size() == brdfs->bricks.size();
  return {std::make_shared<const CellBrdfs>(std::move(*brdfs)), true, saved};
}

BakePlace CellBrdfKind::place(const CellBrdfJob& job) const {
  return {cell_brdf_file_path(job.octree.path), job.octree.must_save, job.octree.keeps};
}

CellBrdfs CellBrdfKind::read(const std::string& path) const { return load_cell_brdf_file(path).brdfs; }

void CellBrdfKind::write(const std::string& path, const CellBrdfJob& job, const CellBrdfs& brdfs, bool complete) const {
  save_cell_brdf_file(path, brdfs, job.octree.scene, complete);
}

std::shared_ptr<const CellBrdfs> run_cell_brdf_job(const CellBrdfJob& job, const std::atomic<bool>& cancel,
                                                   const std::function<void(double)>& progress) {
  CellBrdfKind kind;
  return make_bake(kind, job, {cancel, progress}).value;
}

}  // namespace maquette
