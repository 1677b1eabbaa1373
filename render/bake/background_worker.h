#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <optional>
#include <stop_token>
#include <thread>
#include <utility>

namespace maquette {

/// What a job of a BackgroundWorker is given besides itself.
template <typename Result>
struct BackgroundTask {
  const std::atomic<bool>& cancel;
  std::stop_token stop;                  ///< the same as `cancel`, for what takes a token
  std::function<void(double)> progress;  ///< takes [0, 1]
  /// Hands over a result before the end: it stands for all of the job so far and replaces one that was not taken.
  std::function<void(Result)> publish;
};

/// Runs jobs on a thread of its own; only the newest one counts, or the newest of those that it lets finish. Knows no
/// OpenGL.
template <typename Job, typename Result>
class BackgroundWorker {
 public:
  /// Runs on the worker's thread; gives nothing once cancelled, or when all is published.
  using Work = std::function<std::optional<Result>(const Job&, const BackgroundTask<Result>&)>;
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
    submit(std::move(job), [](Job*, Job&&) {});
  }
  /// The same; `inherit(&job, waiting)` hands on what a job has that this one replaces before it began.
  template <typename Inherit>
  void submit(Job job, const Inherit& inherit) {
    const std::lock_guard lock(mutex_);
    failed_ = nullptr;
    if (!latest_ || !spare_ || !spare_(*latest_, job)) {
      done_.reset();
      cancel_running();
      progress_ = 0.0;
    }
    if (next_) inherit(&job, std::move(*next_));
    next_.emplace(std::move(job));
    changed_.notify_all();
  }
  /// Drops what runs, waits or is done.
  void cancel() {
    const std::lock_guard lock(mutex_);
    next_.reset();
    done_.reset();
    failed_ = nullptr;
    cancel_running();
    changed_.notify_all();
  }
  /// The newest job's newest result, once; waits for one as long as `patience` while there is work. Rethrows what made
  /// the job fail, once.
  std::optional<Result> take(std::chrono::milliseconds patience = {}) {
    std::unique_lock lock(mutex_);
    if (patience.count() > 0) changed_.wait_for(lock, patience, [this] { return done_ || failed_ || idle(); });
    if (failed_) std::rethrow_exception(std::exchange(failed_, nullptr));
    return std::exchange(done_, std::nullopt);
  }
  bool busy() const {
    const std::lock_guard lock(mutex_);
    return !idle();
  }
  /// Of the running job, in [0, 1].
  double progress() const { return progress_; }
  /// Until the newest job is done or failed.
  void wait() {
    std::unique_lock lock(mutex_);
    changed_.wait(lock, [this] { return idle(); });
  }

 private:
  bool idle() const { return !next_ && (!running_ || cancel_); }
  void cancel_running() {
    cancel_ = true;
    stop_.request_stop();
  }
  void publish(Result result) {
    const std::lock_guard lock(mutex_);
    if (cancel_) return;
    done_ = std::move(result);
    changed_.notify_all();
  }
  void run(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (changed_.wait(lock, stop, [this] { return next_.has_value(); })) {
      latest_.emplace(std::move(*next_));
      next_.reset();
      running_ = true;
      cancel_ = false;
      stop_ = std::stop_source();
      progress_ = 0.0;
      const BackgroundTask<Result> task{cancel_, stop_.get_token(), [this](double p) { progress_ = p; },
                                        [this](Result result) { publish(std::move(result)); }};
      lock.unlock();
      std::optional<Result> result;
      std::exception_ptr failed;
      try {
        result = work_(*latest_, task);
      } catch (...) {
        failed = std::current_exception();
      }
      lock.lock();
      running_ = false;
      if (!spare_) latest_.reset();
      if (!cancel_) {
        if (result) done_ = std::move(result);
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
  std::atomic<bool> cancel_{false};  ///< of the running job, as `stop_`
  std::stop_source stop_;
  std::atomic<double> progress_{0.0};
  std::jthread thread_;  // last: it uses all of the above
};

}  // namespace maquette
