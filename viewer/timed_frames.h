#pragma once

#include <deque>
#include <functional>

namespace maquette {

/// When to stop drawing frames so that they take a given time together: short ones stop at the end that is nearest to
/// it, and of long ones (a tenth of the time and more) none begins that would end behind it, by the median of the last
/// ones. There is always one.
class TimedFrames {
 public:
  using Clock = std::function<double()>;  ///< seconds since any moment
  /// The time runs from here on.
  TimedFrames(double limit_s, Clock clock);
  double elapsed_s() const { return clock_() - start_s_; }
  double limit_s() const { return limit_s_; }
  /// A frame has ended.
  void end_frame();
  /// No frame is to begin any more.
  bool over() const;

 private:
  double limit_s_;
  Clock clock_;
  double start_s_, last_s_;
  std::deque<double> frames_s_;  ///< the last ones
};

}  // namespace maquette
