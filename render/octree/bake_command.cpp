#include "render/octree/bake_command.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>

#include "render/octree/cell_brdf_kind.h"
#include "render/octree/octree_file.h"
#include "render/octree/octree_interest.h"
#include "render/octree/technique.h"
#include "render/scene_state/material_overrides.h"
#include "scenes/error.h"

namespace maquette {

namespace {

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

[[noreturn]] void fail_interrupted(const std::string& path) {
  throw Error(path, "the bake was interrupted", "the same command resumes it");
}

OctreeJob make_job(const BakeRequest& request) {
  const Settings& settings = request.settings;
  OctreeJob job = make_octree_job(request.scene, effective_materials(request.scene, request.materials), request.variant,
                                  settings.get_int("octree.depth"));
  job.options.detail = octree_detail(settings);
  job.options.interest = find_interest(settings.get_string("octree.interest"), request.scene, job.geometry);
  const std::string& folder = request.folder.empty() ? settings.get_string("octree.bake") : request.folder;
  job.path = octree_file_path(folder, request.scene.name, job.options.depth);
  if (job.path.empty()) throw Error("maquette bake", "the cache is switched off", "name a folder: -o DIR");
  job.must_save = true;
  return job;
}

std::shared_ptr<const OctreeBricks> bake_octree(const OctreeJob& job, const BakeControl& control) {
  const auto begin = std::chrono::steady_clock::now();
  const auto result = run_octree_job(job, control.cancel, [&](double share) { control.progress("octree", share); });
  if (!result) fail_interrupted(job.path);
  const Octree& octree = result->octree;
  const double cell_mm =
      1000.0 * static_cast<double>(octree.side_m) / static_cast<double>(1 << (octree.depth - octree.detail));
  char text[160];
  std::snprintf(text, sizeof text, ": %zu cells of %.1f mm in %zu nodes, %.1f MB, %.1f s, %zu of %zu bricks reused",
                octree.leaf_count(), octree.empty() ? 0.0 : cell_mm, octree.node_count(),
                static_cast<double>(octree.bytes()) / 1e6, seconds_since(begin), result->bricks->reused,
                result->bricks->bricks.size());
  control.report(job.path + text);
  return result->bricks;
}

void bake_cells(const CellBrdfJob& job, const BakeControl& control) {
  const std::string path = cell_brdf_file_path(job.octree.path);
  const auto begin = std::chrono::steady_clock::now();
  const auto brdfs =
      run_cell_brdf_job(job, control.cancel, [&](double share) { control.progress("cell BRDFs", share); });
  if (!brdfs) fail_interrupted(path);
  char text[160];
  std::snprintf(text, sizeof text,
                ": BRDFs of %zu cells, %zu of them shared, %zu baked now, %.1f s, %zu of %zu bricks reused",
                brdfs->cell_count(), brdfs->shared_count(), brdfs->baked_cells, seconds_since(begin), brdfs->reused,
                brdfs->bricks.size());
  control.report(path + text);
  if (brdfs->baked_cells == 0) return;
  std::snprintf(text, sizeof text,
                "lost in compression: %.1f %% of light, %.1f %% of areas (relative RMS, each cell against itself)",
                100.0 * std::sqrt(brdfs->light_error / std::max(brdfs->light_energy, 1e-30)),
                100.0 * std::sqrt(brdfs->area_error / std::max(brdfs->area_energy, 1e-30)));
  control.report(text);
}

}  // namespace

BakeCommand octree_bake_command() {
  const auto run = [](const BakeRequest& request, const BakeControl& control) {
    CellBrdfJob job;
    job.octree = make_job(request);
    job.bricks = bake_octree(job.octree, control);
    if (request.settings.get_string("octree.brdf") == "none") return;
    job.materials = effective_materials(request.scene, request.materials);
    bake_cells(job, control);
  };
  return {"octree", "the scene's octree and, with octree.brdf, the BRDFs of its cells", run};
}

}  // namespace maquette
