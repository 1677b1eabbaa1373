#include "viewer/still_edges.h"

#include <algorithm>

namespace maquette {

int StillEdges::choose(const Turn& turn) {
  if (turn.disturbed) smooth_ = false;
  if (turn.changed) {
    refused_ = false;
    held_ = 0;
    rest_begin_s_ = turn.now_s;
  }
  if (turn.still_samples <= turn.moving_samples) smooth_ = false;
  if (!hidden(turn.frames)) held_ = 0;
  const bool rests = turn.frames > 0 && turn.now_s - rest_begin_s_ > kRest_s;
  if (!smooth_ && !refused_ && rests && turn.may_begin && turn.still_samples > turn.moving_samples) {
    smooth_ = true;
    held_ = std::min(turn.frames, kMostHeld);
  }
  return smooth_ ? turn.still_samples : turn.moving_samples;
}

void StillEdges::refuse() {
  smooth_ = false;
  refused_ = true;
  held_ = 0;
}

}  // namespace maquette
