#include "viewer/bake_command.h"

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <csignal>
#include <cstdio>
#include <filesystem>

#include "render/material_overrides.h"
#include "render/octree/cell_brdf_worker.h"
#include "render/octree/octree_file.h"
#include "render/octree/octree_interest.h"
#include "render/octree/technique.h"
#include "scenes/error.h"
#include "scenes/suggest.h"
#include "viewer/command_line.h"
#include "viewer/outputs.h"
#include "viewer/session.h"

namespace maquette {

namespace {

std::atomic<bool> g_cancel{false};
static_assert(std::atomic<bool>::is_always_lock_free);

void ask_to_stop(int) { g_cancel = true; }

/// Ctrl+C ends a bake in order, so that what is done is kept.
class InterruptGuard {
 public:
  InterruptGuard() : before_(std::signal(SIGINT, ask_to_stop)) { g_cancel = false; }
  ~InterruptGuard() { std::signal(SIGINT, before_); }
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;

 private:
  void (*before_)(int);
};

std::function<void(double)> print_progress(const char* what) {
  return [what, shown = -1](double fraction) mutable {
    const int percent = static_cast<int>(100.0 * fraction);
    if (percent / 10 == shown / 10 && shown >= 0) return;
    shown = percent;
    std::fprintf(stderr, "%s: %d %%\n", what, percent);
  };
}

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

void bake_cell_brdfs_of(const OctreeJob& octree, const std::shared_ptr<const OctreeBricks>& bricks,
                        const std::vector<Material>& materials) {
  CellBrdfJob job;
  job.octree = octree;
  job.bricks = bricks;
  job.materials = materials;
  const std::string path = cell_brdf_file_path(octree.path);
  const auto begin = std::chrono::steady_clock::now();
  const auto brdfs = run_cell_brdf_job(job, g_cancel, print_progress("cell BRDFs"));
  if (!brdfs) throw Error(path, "the bake was interrupted", "the same command resumes it");
  std::printf("%s: BRDFs of %zu cells, %zu of them shared, %zu baked now, %.1f s, %zu of %zu bricks reused\n",
              path.c_str(), brdfs->cell_count(), brdfs->shared_count(), brdfs->baked_cells, seconds_since(begin),
              brdfs->reused, brdfs->bricks.size());
  if (brdfs->baked_cells > 0)
    std::printf("lost in compression: %.1f %% of light, %.1f %% of areas (relative RMS, each cell against itself)\n",
                100.0 * std::sqrt(brdfs->light_error / std::max(brdfs->light_energy, 1e-30)),
                100.0 * std::sqrt(brdfs->area_error / std::max(brdfs->area_energy, 1e-30)));
}

int bake_octree(const SceneOptions& options) {
  if (!options.output.empty()) prepare_folder("--output", options.output);
  const std::shared_ptr<Scene> scene = load_session_scene(options);
  for (const std::string& warning : scene->warnings) std::fprintf(stderr, "warning: %s\n", warning.c_str());
  OctreeJob job =
      make_octree_job(*scene, find_variant(*scene, options.variant), options.settings.get_int("octree.depth"));
  const bool cell_brdfs = options.settings.get_string("octree.brdf") != "none";
  job.options.detail = octree_detail(options.settings);
  job.options.interest = find_interest(options.settings.get_string("octree.interest"), *scene, job.geometry);
  const std::string folder = options.output.empty() ? options.settings.get_string("octree.bake") : options.output;
  job.path = octree_file_path(folder, scene->name, job.options.depth);
  if (job.path.empty()) throw Error("maquette bake", "the cache is switched off", "name a folder: -o DIR");
  job.must_load = true;
  const InterruptGuard guard;
  const auto begin = std::chrono::steady_clock::now();
  const auto result = run_octree_job(job, g_cancel, print_progress("octree"));
  if (!result) throw Error(job.path, "the bake was interrupted", "the same command resumes it");
  const double seconds = seconds_since(begin);
  const Octree& octree = result->octree;
  const double cell_mm =
      1000.0 * static_cast<double>(octree.side_m) / static_cast<double>(1 << (octree.depth - octree.detail));
  std::printf("%s: %zu cells of %.1f mm in %zu nodes, %.1f MB, %.1f s, %zu of %zu bricks reused\n", job.path.c_str(),
              octree.leaf_count(), octree.empty() ? 0.0 : cell_mm, octree.node_count(),
              static_cast<double>(octree.bytes()) / 1e6, seconds, result->bricks->reused,
              result->bricks->bricks.size());
  if (cell_brdfs) {
    const std::map<std::string, std::string> sources(options.materials.begin(), options.materials.end());
    bake_cell_brdfs_of(job, result->bricks, override_materials(scene->materials, sources));
  }
  return 0;
}

}  // namespace

int run_bake(const CommandLine& line) {
  static const std::vector<std::string> kKinds = {"octree", "slf", "prt"};
  const std::string& kind = line.files.front();
  SceneOptions options = line.options;
  if (line.files.size() > 1) options.scene = line.files[1];
  if (kind == "octree") return bake_octree(options);
  if (kind == "slf" || kind == "prt")
    throw Error("maquette bake " + kind, "this bake is not available in this version");
  throw UsageError("maquette bake " + kind, "there is no such bake", did_you_mean(kind, kKinds));
}

}  // namespace maquette
