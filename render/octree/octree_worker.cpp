#include "render/octree/octree_worker.h"

#include <chrono>
#include <filesystem>

#include "render/octree/octree_file.h"
#include "scenes/error.h"

namespace maquette {

namespace {

constexpr auto kSaveEvery = std::chrono::seconds(10);

std::shared_ptr<const OctreeBricks> load_before(const OctreeJob& job) {
  if (job.before || job.path.empty()) return job.before;
  std::error_code ignored;
  if (!std::filesystem::exists(job.path, ignored)) return nullptr;
  try {
    return std::make_shared<const OctreeBricks>(load_octree_file(job.path).bricks);
  } catch (const Error&) {
    if (job.must_load) throw;
    return nullptr;  // of the cache: as good as absent
  }
}

/// A cache that cannot be written is no error; a bake that was asked for is.
void save(const OctreeJob& job, const OctreeBricks& bricks, bool complete) {
  if (job.path.empty()) return;
  try {
    std::error_code ignored;
    std::filesystem::create_directories(std::filesystem::path(job.path).parent_path(), ignored);
    save_octree_file(job.path, bricks, job.scene, complete);
  } catch (const Error&) {
    if (job.must_load) throw;
  }
}

}  // namespace

OctreeJob make_octree_job(const Scene& scene, int variant, int depth) {
  OctreeJob job;
  job.geometry = flatten(scene);
  const int default_material = static_cast<int>(scene.materials.size());
  for (const DrawItem& item : job.geometry.items) {
    int material = item.patch >= 0 ? scene.patches[static_cast<std::size_t>(item.patch)].material
                                   : material_of(scene.meshes[static_cast<std::size_t>(item.mesh)]
                                                     .primitives[static_cast<std::size_t>(item.primitive)],
                                                 variant);
    if (material < 0 || material > default_material) material = default_material;
    job.materials.push_back(material);
    const bool named = material < default_material;
    const Material* m = named ? &scene.materials[static_cast<std::size_t>(material)] : nullptr;
    job.transmits.push_back(m && (m->glass || m->alpha_mode == AlphaMode::blend));
  }
  job.paint = std::make_shared<const OctreePaint>(scene, scene.materials);
  job.options.depth = depth;
  job.options.detail = kOctreeMaxDetail;
  job.scene = scene.name;
  return job;
}

std::optional<OctreeResult> run_octree_job(const OctreeJob& job, const std::atomic<bool>& cancel,
                                           const std::function<void(double)>& progress) {
  const std::shared_ptr<const OctreeBricks> before = load_before(job);
  const OctreeSource source{job.geometry, job.materials, job.transmits, *job.paint};
  OctreeBricks partial;
  partial.grid = choose_octree_grid(source, job.options, before ? &before->grid : nullptr);
  std::size_t built = 0;
  auto saved = std::chrono::steady_clock::now();
  OctreeProgress watch{&cancel, progress, [&](std::uint32_t code, const OctreeBricks::Entry& entry) {
                         ++built;
                         partial.bricks[code] = entry;
                         if (std::chrono::steady_clock::now() - saved < kSaveEvery) return;
                         save(job, partial, false);
                         saved = std::chrono::steady_clock::now();
                       }};
  auto bricks = build_octree_bricks(source, job.options, before.get(), watch);
  if (!bricks) {
    if (built > 0) save(job, partial, false);
    return std::nullopt;
  }
  partial.bricks.clear();
  OctreeResult result;
  result.octree = assemble_octree(*bricks);
  const bool changed = built > 0 || !before || before->bricks.size() != bricks->bricks.size();
  if (changed) save(job, *bricks, true);
  result.bricks = std::make_shared<const OctreeBricks>(std::move(*bricks));
  return result;
}

}  // namespace maquette
