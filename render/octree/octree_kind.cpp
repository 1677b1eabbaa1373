#include "render/octree/octree_kind.h"

#include "render/octree/octree_file.h"

namespace maquette {

OctreeJob make_octree_job(const Scene& scene, const std::vector<Material>& materials, int variant, int depth) {
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
    const Material* m = named ? &materials[static_cast<std::size_t>(material)] : nullptr;
    job.transmits.push_back(m && (m->glass || m->alpha_mode == AlphaMode::blend));
  }
  job.textures = std::make_shared<const OctreeTextures>(scene, materials);
  job.options.depth = depth;
  job.options.detail = kOctreeMaxDetail;
  job.scene = scene.name;
  return job;
}

Baked<OctreeResult> OctreeKind::load(const OctreeJob& job) {
  if (!job.before) return FileBakeKind::load(job);
  return {std::make_shared<const OctreeResult>(OctreeResult{job.before, {}}), false, true};
}

Baked<OctreeResult> OctreeKind::run(const OctreeJob& job, const Baked<OctreeResult>& kept,
                                    const BakeTask<OctreeResult>& task) {
  const OctreeBricks* before = kept.value ? kept.value->bricks.get() : nullptr;
  const OctreeSource source{job.geometry, job.materials, job.transmits, *job.textures};
  const auto bricks_so_far = std::make_shared<OctreeBricks>();
  const auto part = std::make_shared<const OctreeResult>(OctreeResult{bricks_so_far, {}});
  bricks_so_far->grid = compute_octree_grid(source, job.options, before ? &before->grid : nullptr);
  const OctreeProgress watch{&task.cancel, task.progress, [&](std::uint32_t code, const OctreeBricks::Entry& entry) {
                               bricks_so_far->bricks[code] = entry;
                               task.publish(*part);
                             }};
  auto bricks = build_octree_bricks(source, job.options, before, watch);
  const bool built = !bricks_so_far->bricks.empty();
  if (!bricks) return built ? Baked<OctreeResult>{part} : Baked<OctreeResult>{};
  bricks_so_far->bricks.clear();
  const bool saved = !built && before && before->bricks.size() == bricks->bricks.size();
  OctreeResult result;
  result.octree = assemble_octree(*bricks);
  result.bricks = std::make_shared<const OctreeBricks>(std::move(*bricks));
  return {std::make_shared<const OctreeResult>(std::move(result)), true, saved};
}

OctreeResult OctreeKind::read(const std::string& path) const {
  return {std::make_shared<const OctreeBricks>(load_octree_file(path).bricks), {}};
}

void OctreeKind::write(const std::string& path, const OctreeJob& job, const OctreeResult& result, bool complete) const {
  save_octree_file(path, *result.bricks, job.scene, complete);
}

std::shared_ptr<const OctreeResult> run_octree_job(const OctreeJob& job, const std::atomic<bool>& cancel,
                                                   const std::function<void(double)>& progress) {
  OctreeKind kind;
  return make_bake(kind, job, {cancel, progress}).value;
}

}  // namespace maquette
