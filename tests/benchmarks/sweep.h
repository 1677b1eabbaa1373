#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/benchmarks/stage.h"

namespace maquette::bench {

/// One setting of a mode: time and error of a frame (or of a run of accumulated frames).
struct SweepPoint {
  int samples = 0;
  int frames = 1;
  bool accumulated = false;            ///< a frame of a run; else a single frame
  double wall_ms = 0.0, cpu_ms = 0.0;  ///< medians over the repeats
  double error = 0.0;                  ///< relative RMSE, root mean square over the repeats' seeds
  double shading_samples = 0.0;
  double shade_ms = 0.0, prediction_ms = 0.0, frame_ms = 0.0;  ///< of all frames; shade: the last one's
  double prediction_cpu_ms = 0.0;                              ///< of all frames
  double time(bool cpu) const { return cpu ? cpu_ms : wall_ms; }
};
using Curve = std::vector<SweepPoint>;

/// Time to an error, by single or by accumulated frames, whichever is faster: log-log interpolation between the points
/// around it on the lower envelope; the first point's time if it is good enough already; absent if no point is.
std::optional<double> time_to(const Curve& curve, double error, bool cpu);
/// Error after a time, likewise.
std::optional<double> error_after(const Curve& curve, double time_ms, bool cpu);

/// Frames of the modes, interleaved, with doubling sample counts until both are better than `until` or too slow; then
/// runs of accumulated frames of `bandwidth` and `uniform` at 64 samples. [mode] as given.
std::vector<Curve> sweep(Stage& stage, const std::vector<std::string>& modes, double until);

/// Errors after 1, 2, 3, 4, 6, 8, 12, ... frames of 64 samples of a view at rest, until better than `until` or too
/// slow, with interleaved runs of the modes. [mode] as given.
std::vector<Curve> accumulate(Stage& stage, const std::vector<std::string>& modes, double until,
                              const Reference& reference);

}  // namespace maquette::bench
