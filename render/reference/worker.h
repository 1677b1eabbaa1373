#pragma once

#include <chrono>
#include <optional>

#include "render/bake/background_worker.h"
#include "render/reference/reference.h"

namespace maquette {

/// Traces pictures on a thread of its own, coarse ones first; only the newest job counts. Knows no OpenGL.
class ReferenceWorker {
 public:
  struct Job {
    /// What to trace; null: the scene of the job before, whose hierarchy and tables are kept.
    std::shared_ptr<const Scene> scene;
    std::shared_ptr<const FlatGeometry> geometry;
    std::shared_ptr<const Environment> environment;
    int variant = -1;
    PictureRequest picture;
    int most_paths = 1024;  ///< a pixel; then it rests
  };
  struct Update {
    Image mean;     ///< at the size asked for
    int paths = 0;  ///< a pixel; 0: coarse, one path for several pixels
    double relative_error = 0.0;
    ReferenceCounts counts;
  };

  ReferenceWorker()
      : worker_([this](const Job& job, const BackgroundTask<Update>& task) {
          trace(job, task);
          return std::nullopt;
        }) {}

  /// Starts `job`; one that is still running is cancelled and its pictures never shown. Does not wait.
  void submit(Job job);
  /// The newest picture, once; waits for one as long as `patience` while there is work. Rethrows what made a job fail,
  /// once.
  std::optional<Update> take(std::chrono::milliseconds patience) { return worker_.take(patience); }

 private:
  void trace(const Job& job, const BackgroundTask<Update>& task);

  // Of the worker's thread alone:
  std::shared_ptr<const PathScene> scene_;
  MeasuredLibrary library_;
  BackgroundWorker<Job, Update> worker_;  // last: it uses all of the above
};

}  // namespace maquette
