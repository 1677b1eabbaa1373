#pragma once

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cstddef>
#include <functional>
#include <stop_token>
#include <utility>

#include "render/reference/reference.h"

namespace maquette {

/// Tells when a pass has to end early.
class Halt {
 public:
  Halt(std::stop_token stop, const Deadline& deadline) : stop_(std::move(stop)), deadline_(deadline) {}
  bool operator()() const {
    return stop_.stop_requested() || (deadline_ && std::chrono::steady_clock::now() >= *deadline_);
  }
  const std::stop_token& stop() const { return stop_; }

 private:
  std::stop_token stop_;
  Deadline deadline_;
};

/// Reports progress about 100 times.
class Progress {
 public:
  Progress(const std::function<void(double)>& report, std::size_t total) : report_(report), total_(total) {}
  void add(std::size_t count) const {
    const std::size_t before = done_.fetch_add(count);
    if (report_ && (before + count) * 100 / total_ != before * 100 / total_)
      report_(std::min(static_cast<double>(before + count) / static_cast<double>(total_), 1.0));
  }

 private:
  const std::function<void(double)>& report_;
  std::size_t total_;
  mutable std::atomic<std::size_t> done_{0};
};

}  // namespace maquette
