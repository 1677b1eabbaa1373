#include "viewer/report/stop_signal.h"

namespace maquette::report {

namespace {

volatile std::sig_atomic_t stop_asked = 0;  // a signal handler can reach nothing else

void ask_to_stop(int) { stop_asked = 1; }

}  // namespace

StopSignal::StopSignal() {
  stop_asked = 0;
  struct sigaction action {};
  action.sa_handler = ask_to_stop;
  action.sa_flags = static_cast<int>(SA_RESETHAND);
  sigaction(SIGINT, &action, &old_interrupt_);
  sigaction(SIGTERM, &action, &old_terminate_);
}

StopSignal::~StopSignal() {
  sigaction(SIGINT, &old_interrupt_, nullptr);
  sigaction(SIGTERM, &old_terminate_, nullptr);
}

bool StopSignal::asked() { return stop_asked != 0; }

}  // namespace maquette::report
