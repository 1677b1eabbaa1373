#include "render/octree/cell_brdf_worker.h"

#include <chrono>
#include <filesystem>

#include "scenes/error.h"

namespace maquette {

namespace {

constexpr auto kSaveEvery = std::chrono::seconds(30);

std::shared_ptr<const CellBrdfs> load_before(const CellBrdfJob& job, const std::string& path) {
  if (job.before || path.empty()) return job.before;
  std::error_code ignored;
  if (!std::filesystem::exists(path, ignored)) return nullptr;
  try {
    return std::make_shared<const CellBrdfs>(load_cell_brdf_file(path).brdfs);
  } catch (const Error&) {
    if (job.octree.must_load) throw;
    return nullptr;  // of the cache: as good as absent
  }
}

/// A cache that cannot be written is no error; a bake that was asked for is.
void save(const CellBrdfJob& job, const std::string& path, const CellBrdfs& brdfs, bool complete) {
  if (path.empty()) return;
  try {
    std::error_code ignored;
    std::filesystem::create_directories(std::filesystem::path(path).parent_path(), ignored);
    save_cell_brdf_file(path, brdfs, job.octree.scene, complete);
  } catch (const Error&) {
    if (job.octree.must_load) throw;
  }
}

}  // namespace

std::optional<CellBrdfs> run_cell_brdf_job(const CellBrdfJob& job, const std::atomic<bool>& cancel,
                                           const std::function<void(double)>& progress) {
  const std::string path = cell_brdf_file_path(job.octree.path);
  const std::shared_ptr<const CellBrdfs> before = load_before(job, path);
  const OctreeJob& o = job.octree;
  const OctreeSource source{o.geometry, o.materials, o.transmits, *o.paint};
  CellTables tables;
  const std::vector<CellMaterial> materials = make_cell_materials(job.materials, &tables);
  // What an interrupted bake leaves: the bricks before, replaced by new ones as they come.
  CellBrdfs partial = before ? *before : CellBrdfs{};
  bool changed = false;
  auto saved = std::chrono::steady_clock::now();
  const CellBrdfProgress watch{&cancel, progress,
                               [&](const CellBrdfs& whole, std::uint32_t code, const CellBrdfs::Brick& brick) {
                                 if (!changed) partial.pca = whole.pca, partial.fit_loss = whole.fit_loss;
                                 changed = true;
                                 partial.bricks[code] = brick;
                                 if (std::chrono::steady_clock::now() - saved < kSaveEvery) return;
                                 save(job, path, partial, false);
                                 saved = std::chrono::steady_clock::now();
                               },
                               [&] {
                                 partial = {};
                                 changed = false;
                               }};
  auto brdfs = bake_cell_brdfs({source, *job.bricks, materials}, job.options, before.get(), watch);
  if (!brdfs) {
    if (changed) save(job, path, partial, false);
    return std::nullopt;
  }
  if (changed || !before || before->bricks.size() != brdfs->bricks.size()) save(job, path, *brdfs, true);
  return brdfs;
}

}  // namespace maquette
