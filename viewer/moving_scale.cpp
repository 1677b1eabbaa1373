#include "viewer/moving_scale.h"

#include <algorithm>
#include <iterator>

namespace maquette {

namespace {
/// No coarser: shapes dissolve below half the resolution, which disturbs more than a low rate.
constexpr float kScales[] = {1.0f, 0.7f, 0.5f};
/// Within a move the resolution rises only for a large gain, so that the picture does not flicker.
constexpr double kFinerShare = 0.5;
constexpr int kSlowFrames = 2;
constexpr double kNewest = 0.5;  ///< weight of the newest frame in the smoothed cost
}  // namespace

float MovingScale::next_scale(Kind kind, double full_px, float most) {
  Cost& c = cost(kind);
  const bool same_move = moving_ && kind_ == kind && scale_ <= most;
  moving_ = true;
  kind_ = kind;
  // Frames without reuse do not predict those of a rotating environment: it begins at full size and is measured.
  const double ms_per_px = c.ms_per_px > 0.0 || kind == Kind::light ? c.ms_per_px : still_ms_per_px_;
  if (same_move && c.slow < kSlowFrames) {
    for (const float scale : kScales)
      if (scale <= most && scale > scale_ && ms_per_px * full_px * scale * scale <= kFinerShare * kFluid_ms)
        return scale_ = scale;
    return scale_;
  }
  c.slow = 0;
  const float limit = same_move ? std::min(most, 0.99f * scale_) : most;
  scale_ = std::min(most, *std::rbegin(kScales));
  for (const float scale : kScales) {
    if (scale > limit || ms_per_px * full_px * scale * scale > kFluid_ms) continue;
    scale_ = scale;
    break;
  }
  return scale_;
}

void MovingScale::note(Kind kind, double ms, double px) {
  Cost& c = cost(kind);
  const double now = ms / std::max(px, 1.0);
  c.ms_per_px = c.ms_per_px > 0.0 ? c.ms_per_px + kNewest * (now - c.ms_per_px) : now;
  c.slow = ms > kFluid_ms ? c.slow + 1 : 0;
}

void MovingScale::note_still(double ms, double px) { still_ms_per_px_ = ms / std::max(px, 1.0); }

}  // namespace maquette
