#pragma once

#include <atomic>
#include <csignal>

namespace maquette {

/// While it lives, the first Ctrl-C (SIGINT) or SIGTERM only asks to stop, so that what is done is kept; the second
/// ends the program as usual. One at a time.
class InterruptGuard {
 public:
  InterruptGuard();
  ~InterruptGuard();
  InterruptGuard(const InterruptGuard&) = delete;
  InterruptGuard& operator=(const InterruptGuard&) = delete;
  static bool asked() { return flag(); }
  /// For work that is told to stop by a flag.
  static const std::atomic<bool>& flag();

 private:
  struct sigaction old_interrupt_ {
  }, old_terminate_{};
};

}  // namespace maquette
