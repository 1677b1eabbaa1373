#pragma once

#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>
#include <vector>

#include "render/visibility/visibility_bake.h"

namespace maquette {

/// Bakes visibility on a thread of its own; only the newest job counts. Knows no OpenGL.
class VisibilityWorker {
 public:
  struct Job {
    FlatGeometry geometry;  ///< positions, normals, indices and items suffice
    std::vector<bool> transmits;
  };
  VisibilityWorker();
  ~VisibilityWorker();  ///< cancels and waits
  VisibilityWorker(const VisibilityWorker&) = delete;
  VisibilityWorker& operator=(const VisibilityWorker&) = delete;

  /// Starts `job`; one that is still running is cancelled and its result never shown. Does not wait.
  void submit(Job job);
  /// Drops what runs, waits or is done.
  void cancel();
  /// The newest job's result, once. Rethrows what made it fail, once.
  std::optional<VisibilityBake> take();
  bool busy() const;
  /// Of the running job, in [0, 1].
  double progress() const { return progress_; }
  /// Until the newest job is done or failed.
  void wait();

 private:
  void run(const std::stop_token& stop);

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<Job> next_;
  std::optional<VisibilityBake> done_;
  std::exception_ptr failed_;
  bool running_ = false;
  std::atomic<bool> cancel_{false};
  std::atomic<double> progress_{0.0};
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace maquette
