#pragma once

#include <csignal>

namespace maquette::report {

/// While it lives, the first Ctrl-C (SIGINT) or SIGTERM only asks to stop; the second ends the program as usual.
class StopSignal {
 public:
  StopSignal();
  ~StopSignal();
  StopSignal(const StopSignal&) = delete;
  StopSignal& operator=(const StopSignal&) = delete;
  static bool asked();

 private:
  struct sigaction old_interrupt_ {
  }, old_terminate_{};
};

}  // namespace maquette::report
