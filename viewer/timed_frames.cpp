#include "viewer/timed_frames.h"

#include <utility>
#include <vector>

#include "viewer/stats.h"

namespace maquette {

namespace {
constexpr std::size_t kKept = 5;
constexpr double kLongShare = 0.1;  // of the time: so long a frame is a long one
}  // namespace

TimedFrames::TimedFrames(double limit_s, Clock clock)
    : limit_s_(limit_s), clock_(std::move(clock)), start_s_(clock_()), last_s_(start_s_) {}

void TimedFrames::end_frame() {
  const double now_s = clock_();
  frames_s_.push_back(now_s - last_s_);
  if (frames_s_.size() > kKept) frames_s_.pop_front();
  last_s_ = now_s;
}

bool TimedFrames::over() const {
  if (frames_s_.empty()) return false;
  const double next_s = median({frames_s_.begin(), frames_s_.end()});
  const double margin_s = next_s > kLongShare * limit_s_ ? next_s : 0.5 * next_s;
  // Rounding of a sum of frames must not take the last one.
  return last_s_ - start_s_ + margin_s > limit_s_ * (1.0 + 1e-9);
}

}  // namespace maquette
