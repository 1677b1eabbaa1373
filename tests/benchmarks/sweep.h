#pragma once

#include <optional>
#include <string>
#include <vector>

#include "tests/benchmarks/stage.h"

namespace maquette::bench {

/// One setting of a mode: how long a frame (or a run of accumulated frames) takes and how wrong it is.
struct SweepPoint {
  int samples = 0;
  int frames = 1;
  bool accumulated = false;            ///< one of a run of frames, else a frame on its own
  double wall_ms = 0.0, cpu_ms = 0.0;  ///< medians over the repeats
  double error = 0.0;                  ///< relative RMSE, root mean square over the repeats' seeds
  double shading_samples = 0.0;
  double shade_ms = 0.0, prediction_ms = 0.0, frame_ms = 0.0;  ///< of all frames; shade: the last one's
  double prediction_cpu_ms = 0.0;                              ///< of all frames
  double time(bool cpu) const { return cpu ? cpu_ms : wall_ms; }
};
using Curve = std::vector<SweepPoint>;

/// Time to an error, by frames on their own or by accumulated ones, whichever gets there first: log-log between the
/// points around it on the lower envelope; the first point's time when that is good enough already; absent when no
/// point is.
std::optional<double> time_to(const Curve& curve, double error, bool cpu);
/// Error after a time, likewise.
std::optional<double> error_after(const Curve& curve, double time_ms, bool cpu);

/// Frames of the modes by turns, sample counts doubling until both are better than `until` or too slow; then runs of
/// accumulated frames of `bandwidth` and `uniform` at 64 samples. [mode] as given.
std::vector<Curve> sweep(Stage& stage, const std::vector<std::string>& modes, double until);

/// Errors after 1, 2, 3, 4, 6, 8, 12, ... frames of 64 samples while nothing moves, until better than `until` or too
/// slow, in runs of the modes by turns. [mode] as given.
std::vector<Curve> accumulate(Stage& stage, const std::vector<std::string>& modes, double until,
                              const Reference& reference);

}  // namespace maquette::bench
