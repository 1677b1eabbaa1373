#include "render/reference/worker.h"

#include <algorithm>
#include <utility>

namespace maquette {

namespace {

using Clock = std::chrono::steady_clock;
constexpr std::chrono::milliseconds kBetweenNews{250};

/// Every pixel of the coarse picture as a square.
Image magnify(const Image& coarse, int width, int height) {
  Image out(width, height, coarse.channels);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x) {
      const int sx = std::min(x * coarse.width / width, coarse.width - 1);
      const int sy = std::min(y * coarse.height / height, coarse.height - 1);
      for (int c = 0; c < coarse.channels; ++c) out.at(x, y, c) = coarse.at(sx, sy, c);
    }
  return out;
}

}  // namespace

ReferenceWorker::ReferenceWorker() : thread_([this](const std::stop_token& stop) { run(stop); }) {}

ReferenceWorker::~ReferenceWorker() {
  thread_.request_stop();
  const std::lock_guard lock(mutex_);
  job_stop_.request_stop();
}

void ReferenceWorker::submit(Job job) {
  const std::lock_guard lock(mutex_);
  job_stop_.request_stop();
  // A scene that no one has traced yet must not be forgotten for the camera that moved meanwhile.
  if (!job.scene && next_ && next_->scene) {
    job.scene = next_->scene;
    job.geometry = next_->geometry;
    job.environment = next_->environment;
    job.variant = next_->variant;
  }
  next_ = std::move(job);
  news_.reset();
  changed_.notify_all();
}

std::optional<ReferenceWorker::News> ReferenceWorker::take(std::chrono::milliseconds patience) {
  std::unique_lock lock(mutex_);
  changed_.wait_for(lock, patience, [&] { return news_ || failed_ || !(working_ || next_); });
  if (failed_) std::rethrow_exception(std::exchange(failed_, nullptr));
  return std::exchange(news_, std::nullopt);
}

void ReferenceWorker::run(const std::stop_token& stop) {
  std::unique_lock lock(mutex_);
  while (changed_.wait(lock, stop, [&] { return next_.has_value(); })) {
    const Job job = std::move(*next_);
    next_.reset();
    job_stop_ = std::stop_source();
    const std::stop_token job_stop = job_stop_.get_token();
    working_ = true;
    lock.unlock();
    std::exception_ptr failed;
    try {
      trace(job, job_stop);
    } catch (...) {
      failed = std::current_exception();
    }
    lock.lock();
    working_ = false;
    if (failed && !job_stop.stop_requested()) failed_ = failed;
    changed_.notify_all();
  }
}

void ReferenceWorker::trace(const Job& job, const std::stop_token& stop) {
  if (job.scene)
    scene_ = build_path_scene({.scene = *job.scene,
                               .environment = job.environment,
                               .variant = job.variant,
                               .geometry = job.geometry.get(),
                               .library = &library_});
  if (!scene_) return;
  const PictureRequest& wanted = job.picture;
  for (const int divisor : {8, 4, 2}) {
    PictureRequest coarse = wanted;
    coarse.width = std::max(wanted.width / divisor, 1);
    coarse.height = std::max(wanted.height / divisor, 1);
    ReferencePicture picture(scene_, coarse);
    if (!picture.add(1, stop)) return;
    publish({magnify(picture.mean(), wanted.width, wanted.height), 0, 0.0, picture.counts()}, stop);
  }
  ReferencePicture picture(scene_, wanted);
  Clock::time_point last;
  while (picture.samples() < job.most_paths) {
    if (!picture.add(1, stop)) return;
    if (Clock::now() - last < kBetweenNews && picture.samples() < job.most_paths) continue;
    last = Clock::now();
    publish({picture.mean(), picture.samples(), picture.relative_error(), picture.counts()}, stop);
  }
}

void ReferenceWorker::publish(News news, const std::stop_token& stop) {
  const std::lock_guard lock(mutex_);
  if (stop.stop_requested()) return;
  news_ = std::move(news);
  changed_.notify_all();
}

}  // namespace maquette
