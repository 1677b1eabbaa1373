#pragma once

#include <atomic>
#include <condition_variable>
#include <exception>
#include <mutex>
#include <optional>
#include <thread>

#include "render/indirect/indirect_light.h"

namespace maquette {

struct IndirectJob {
  std::shared_ptr<const IndirectInput> input;
  std::shared_ptr<const VisibilityBake> visibility;
  IndirectSky sky;
};

/// The bake of a job, through the disk cache (by content). `links` holds those of the last input, so that a sky that
/// turns costs no rays; they are traced only when the cache does not have the answer. Null once `cancel` is set.
std::optional<IndirectBake> load_indirect(const IndirectJob& job, std::shared_ptr<const IndirectLinks>* links,
                                          const std::atomic<bool>& cancel,
                                          const std::function<void(double)>& progress = {});

/// Bakes indirect light on a thread of its own. A newer sky waits for the one in work (a light that turns all the time
/// would else never be seen); newer surfaces stop it. Knows no OpenGL.
class IndirectWorker {
 public:
  IndirectWorker();
  ~IndirectWorker();  ///< cancels and waits
  IndirectWorker(const IndirectWorker&) = delete;
  IndirectWorker& operator=(const IndirectWorker&) = delete;

  void submit(IndirectJob job);
  void cancel();
  struct Result {
    IndirectBake bake;
    IndirectSky sky;
    std::shared_ptr<const IndirectInput> input;
    std::size_t link_bytes = 0;
  };
  /// The newest that is done, once. Rethrows what made it fail, once.
  std::optional<Result> take();
  bool busy() const;
  double progress() const { return progress_; }
  void wait();

 private:
  void run(const std::stop_token& stop);

  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<IndirectJob> next_;
  std::shared_ptr<const IndirectInput> running_input_;
  std::optional<Result> done_;
  std::exception_ptr failed_;
  bool running_ = false;
  std::atomic<bool> cancel_{false};
  std::atomic<double> progress_{0.0};
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace maquette
