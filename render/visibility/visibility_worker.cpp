#include "render/visibility/visibility_worker.h"

#include <utility>

namespace maquette {

VisibilityWorker::VisibilityWorker() : thread_([this](const std::stop_token& stop) { run(stop); }) {}

VisibilityWorker::~VisibilityWorker() {
  cancel();
  thread_.request_stop();
}

void VisibilityWorker::submit(Job job) {
  const std::lock_guard lock(mutex_);
  next_ = std::move(job);
  done_.reset();
  failed_ = nullptr;
  cancel_ = true;
  progress_ = 0.0;
  changed_.notify_all();
}

void VisibilityWorker::cancel() {
  const std::lock_guard lock(mutex_);
  next_.reset();
  done_.reset();
  failed_ = nullptr;
  cancel_ = true;
  changed_.notify_all();
}

std::optional<VisibilityBake> VisibilityWorker::take() {
  const std::lock_guard lock(mutex_);
  if (failed_) std::rethrow_exception(std::exchange(failed_, nullptr));
  return std::exchange(done_, std::nullopt);
}

bool VisibilityWorker::busy() const {
  const std::lock_guard lock(mutex_);
  return next_.has_value() || (running_ && !cancel_);
}

void VisibilityWorker::wait() {
  std::unique_lock lock(mutex_);
  changed_.wait(lock, [this] { return !next_ && (!running_ || cancel_); });
}

void VisibilityWorker::run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [this] { return next_.has_value(); })) {
    const Job job = std::move(*next_);
    next_.reset();
    running_ = true;
    cancel_ = false;
    progress_ = 0.0;
    lock.unlock();
    std::optional<VisibilityBake> bake;
    std::exception_ptr failed;
    try {
      bake = load_visibility(job.geometry, job.transmits, cancel_, [this](double p) { progress_ = p; });
    } catch (...) {
      failed = std::current_exception();
    }
    lock.lock();
    running_ = false;
    if (!cancel_) {
      done_ = std::move(bake);
      failed_ = failed;
    }
    changed_.notify_all();
  }
}

}  // namespace maquette
