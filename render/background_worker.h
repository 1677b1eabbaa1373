#pragma once

#include <atomic>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <thread>
#include <utility>

namespace maquette {

/// Runs jobs on a thread of its own; only the newest one counts, or the newest of those that it lets finish. Knows no
/// OpenGL.
template <typename Job, typename Result>
class BackgroundWorker {
 public:
  /// Runs on the worker's thread; gives nothing once `cancel` is set. Progress in [0, 1].
  using Work = std::function<std::optional<Result>(const Job&, const std::atomic<bool>& cancel,
                                                   const std::function<void(double)>& progress)>;
  /// Whether `next` lets `before` finish, and its result be shown, before it takes its turn.
  using Spare = std::function<bool(const Job& before, const Job& next)>;
  explicit BackgroundWorker(Work work, Spare spare = {})
      : work_(std::move(work)), spare_(std::move(spare)), thread_([this](const std::stop_token& stop) { run(stop); }) {}
  ~BackgroundWorker() {  ///< cancels and waits
    cancel();
    thread_.request_stop();
  }
  BackgroundWorker(const BackgroundWorker&) = delete;
  BackgroundWorker& operator=(const BackgroundWorker&) = delete;

  /// Starts `job`; one that is still running is cancelled and its result never shown, unless it is spared. Does not
  /// wait.
  void submit(Job job) {
    const std::lock_guard lock(mutex_);
    failed_ = nullptr;
    if (!latest_ || !spare_ || !spare_(*latest_, job)) {
      done_.reset();
      cancel_ = true;
      progress_ = 0.0;
    }
    next_.emplace(std::move(job));
    changed_.notify_all();
  }
  /// Drops what runs, waits or is done.
  void cancel() {
    const std::lock_guard lock(mutex_);
    next_.reset();
    done_.reset();
    failed_ = nullptr;
    cancel_ = true;
    changed_.notify_all();
  }
  /// The newest job's result, once. Rethrows what made it fail, once.
  std::optional<Result> take() {
    const std::lock_guard lock(mutex_);
    if (failed_) std::rethrow_exception(std::exchange(failed_, nullptr));
    return std::exchange(done_, std::nullopt);
  }
  bool busy() const {
    const std::lock_guard lock(mutex_);
    return next_.has_value() || (running_ && !cancel_);
  }
  /// Of the running job, in [0, 1].
  double progress() const { return progress_; }
  /// Until the newest job is done or failed.
  void wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return !next_ && (!running_ || cancel_); });
  }

 private:
  void run(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (changed_.wait(lock, stop, [this] { return next_.has_value(); })) {
      latest_.emplace(std::move(*next_));
      next_.reset();
      running_ = true;
      cancel_ = false;
      progress_ = 0.0;
      lock.unlock();
      std::optional<Result> result;
      std::exception_ptr failed;
      try {
        result = work_(*latest_, cancel_, [this](double p) { progress_ = p; });
      } catch (...) {
        failed = std::current_exception();
      }
      lock.lock();
      running_ = false;
      if (!spare_) latest_.reset();
      if (!cancel_) {
        done_ = std::move(result);
        failed_ = failed;
      }
      changed_.notify_all();
    }
  }

  Work work_;
  Spare spare_;
  mutable std::mutex mutex_;
  std::condition_variable_any changed_;
  std::optional<Job> next_;
  std::optional<Job> latest_;  ///< in work, or what is done came of it
  std::optional<Result> done_;
  std::exception_ptr failed_;
  bool running_ = false;
  std::atomic<bool> cancel_{false};
  std::atomic<double> progress_{0.0};
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace maquette
