#pragma once

#include <chrono>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

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
  struct News {
    Image mean;     ///< at the size asked for
    int paths = 0;  ///< a pixel; 0: coarse, one path for several pixels
    double relative_error = 0.0;
    ReferenceCounts counts;
  };

  ReferenceWorker();
  ~ReferenceWorker();  ///< cancels and waits
  ReferenceWorker(const ReferenceWorker&) = delete;
  ReferenceWorker& operator=(const ReferenceWorker&) = delete;

  /// Starts `job`; one that is still running is cancelled and its pictures never shown. Does not wait.
  void submit(Job job);
  /// The newest picture, once; waits for one as long as `patience` while there is work. Rethrows what made a job fail,
  /// once.
  std::optional<News> take(std::chrono::milliseconds patience);

 private:
  void run(const std::stop_token& stop);
  void trace(const Job& job, const std::stop_token& stop);
  void publish(News news, const std::stop_token& stop);

  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<Job> next_;
  std::optional<News> news_;
  std::exception_ptr failed_;
  std::stop_source job_stop_;
  bool working_ = false;
  // Of the thread alone:
  std::shared_ptr<const PathScene> scene_;
  MeasuredLibrary library_;
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace maquette
