#include "viewer/still_edges.h"

#include <algorithm>

namespace maquette {

int StillEdges::next_samples(const Input& input) {
  if (input.disturbed) smooth_ = false;
  if (input.changed) {
    refused_ = false;
    held_ = 0;
    rest_begin_s_ = input.now_s;
  }
  if (input.still_samples <= input.moving_samples) smooth_ = false;
  if (!hidden(input.frames)) held_ = 0;
  const bool rests = input.frames > 0 && input.now_s - rest_begin_s_ > kRest_s;
  if (!smooth_ && !refused_ && rests && input.may_begin && input.still_samples > input.moving_samples) {
    smooth_ = true;
    held_ = std::min(input.frames, kMostHeld);
  }
  return smooth_ ? input.still_samples : input.moving_samples;
}

void StillEdges::refuse() {
  smooth_ = false;
  refused_ = true;
  held_ = 0;
}

}  // namespace maquette
