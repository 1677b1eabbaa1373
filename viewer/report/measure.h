#pragma once

#include <string>
#include <vector>

#include "viewer/report/data.h"
#include "viewer/report/references.h"
#include "viewer/report/studio.h"

namespace maquette::report {

/// One request, drawn `repeats` times with different seeds after a warm-up; short frames are timed more often.
struct Measurement {
  std::vector<double> wall_ms, cpu_ms;
  std::vector<Image> pictures;
  FrameStats stats;  ///< of the last frame
};
/// `warm`: a cheaper request that creates the same resources.
Measurement measure_frames(Renderer* renderer, const FrameRequest& request, const FrameRequest& warm, int repeats);

/// Time, memory and error of a measurement; names, scope and pictures are left to the caller.
Point judge_measurement(const Measurement& measurement, const Judge& judge, Image* flip_map = nullptr);
}  // namespace maquette::report
