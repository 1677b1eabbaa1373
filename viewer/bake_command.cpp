#include "viewer/bake_command.h"

#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <filesystem>

#include "render/octree/octree_file.h"
#include "render/octree/octree_worker.h"
#include "scenes/error.h"
#include "scenes/suggest.h"
#include "viewer/command_line.h"
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

int bake_octree(const SceneOptions& options) {
  const std::shared_ptr<Scene> scene = load_session_scene(options);
  for (const std::string& warning : scene->warnings) std::fprintf(stderr, "warning: %s\n", warning.c_str());
  OctreeJob job =
      make_octree_job(*scene, find_variant(*scene, options.variant), options.settings.get_int("octree.depth"));
  const std::string folder = options.output.empty() ? options.settings.get_string("octree.bake") : options.output;
  job.path = octree_file_path(folder, scene->name, job.options.depth);
  if (job.path.empty()) throw Error("maquette bake", "the cache is switched off", "name a folder: -o DIR");
  job.must_load = true;
  const InterruptGuard guard;
  const auto begin = std::chrono::steady_clock::now();
  int shown = -1;
  const auto result = run_octree_job(job, g_cancel, [&](double fraction) {
    const int percent = static_cast<int>(100.0 * fraction);
    if (percent / 10 == shown / 10 && shown >= 0) return;
    shown = percent;
    std::fprintf(stderr, "octree: %d %%\n", percent);
  });
  if (!result) throw Error(job.path, "the bake was interrupted", "the same command resumes it");
  const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const Octree& octree = result->octree;
  const double cell_mm = 1000.0 * static_cast<double>(octree.side_m) / static_cast<double>(1 << octree.depth);
  std::printf("%s: %zu cells of %.1f mm in %zu nodes, %.1f MB, %.1f s, %zu of %zu bricks reused\n", job.path.c_str(),
              octree.leaf_count(), octree.empty() ? 0.0 : cell_mm, octree.node_count(),
              static_cast<double>(octree.bytes()) / 1e6, seconds, result->bricks->reused,
              result->bricks->bricks.size());
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
