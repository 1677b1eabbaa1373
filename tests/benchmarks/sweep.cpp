#include "tests/benchmarks/sweep.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>

#include "tests/support/local_bandwidth.h"

namespace maquette::bench {
namespace {

Curve sorted_by_time(Curve curve, bool cpu) {
  std::sort(curve.begin(), curve.end(),
            [cpu](const SweepPoint& a, const SweepPoint& b) { return a.time(cpu) < b.time(cpu); });
  return curve;
}

/// Only the points that are better than all faster ones, separately for single and for accumulated frames. Between two
/// points of one kind the curve is interpolated, but not between points of both kinds.
std::array<Curve, 2> lower_envelopes(const Curve& curve, bool cpu) {
  std::array<Curve, 2> envelopes;
  for (const SweepPoint& p : sorted_by_time(curve, cpu)) {
    Curve& envelope = envelopes[p.accumulated ? 1 : 0];
    if (envelope.empty() || p.error < envelope.back().error) envelope.push_back(p);
  }
  return envelopes;
}

double interpolate_log(double x, double x0, double x1, double y0, double y1) {
  const double t = std::log(x / x0) / std::log(x1 / x0);
  return std::exp(std::log(y0) + t * std::log(y1 / y0));
}

struct Trial {
  Clock time;
  int frames = 0;
  double error = 0.0;
  FrameStats stats;                                                     ///< of the last frame, shading_samples of all
  double prediction_ms = 0.0, prediction_cpu_ms = 0.0, frame_ms = 0.0;  ///< of all frames
};

Clock pass_time(const FrameStats& stats, const std::string& name) {
  for (const PassTime& p : stats.passes)
    if (p.name == name) return {p.ms, p.cpu_ms};
  return {};
}

void add_frame(const FrameStats& stats, Trial* trial) {
  for (const char* pass : {"bandwidth", "pyramid", "measure"}) {
    const Clock time = pass_time(stats, pass);
    trial->prediction_ms += time.wall_ms;
    trial->prediction_cpu_ms += time.cpu_ms;
  }
  trial->frame_ms += stats.frame_ms;
}

SweepPoint summarise(const std::vector<Trial>& trials, int samples, int frames) {
  SweepPoint p;
  p.samples = samples;
  p.frames = frames;
  std::vector<double> wall, cpu, shade, prediction, prediction_cpu, frame;
  double square = 0.0;
  for (const Trial& t : trials) {
    wall.push_back(t.time.wall_ms);
    cpu.push_back(t.time.cpu_ms);
    shade.push_back(pass_time(t.stats, "shade").wall_ms);
    prediction.push_back(t.prediction_ms);
    prediction_cpu.push_back(t.prediction_cpu_ms);
    frame.push_back(t.frame_ms);
    square += t.error * t.error;
  }
  p.wall_ms = test::median(wall);
  p.cpu_ms = test::median(cpu);
  p.shade_ms = test::median(shade);
  p.prediction_ms = test::median(prediction);
  p.prediction_cpu_ms = test::median(prediction_cpu);
  p.frame_ms = test::median(frame);
  p.error = std::sqrt(square / static_cast<double>(trials.size()));
  p.shading_samples = static_cast<double>(trials.back().stats.shading_samples);
  return p;
}

void log_point(const std::string& name, const std::string& mode, const SweepPoint& p) {
  std::fprintf(
      stderr,
      "  %-16s %-9s samples %4d frames %4d  wall %8.1f ms  cpu %8.1f ms  error %6.2f %%  %.3g Msamples  prediction "
      "%.1f and %.1f %% (CPU)\n",
      name.c_str(), mode.c_str(), p.samples, p.frames, p.wall_ms, p.cpu_ms, 100.0 * p.error, p.shading_samples * 1e-6,
      100.0 * p.prediction_ms / std::max(p.frame_ms, 1e-9), 100.0 * p.prediction_cpu_ms / std::max(p.cpu_ms, 1e-9));
}

/// A frame that reuses nothing of the one before.
FrameRequest whole_frame(Stage& stage, const std::string& mode, int samples, std::uint32_t seed) {
  FrameRequest r = stage.request(mode, samples, seed);
  r.settings.set_from_text("shading.reuse", "false");
  return r;
}

Trial one_frame(Stage& stage, const std::string& mode, int samples, std::uint32_t seed, const Reference& reference) {
  Renderer& renderer = stage.renderer();
  renderer.render(whole_frame(stage, mode, 4, seed));  // the mode's targets and programs
  Trial trial;
  const Clock begin = now();
  trial.stats = renderer.render(whole_frame(stage, mode, samples, seed));
  trial.time = now() - begin;
  add_frame(trial.stats, &trial);
  trial.error = error_against(renderer.read_radiance(), reference);
  return trial;
}

/// Whether a run is measured after so many frames.
bool is_checkpoint(int frame) {
  const auto n = static_cast<unsigned>(frame);
  return std::has_single_bit(n) || (n % 3 == 0 && std::has_single_bit(n / 3));
}

constexpr int kRunSamples = 64;

/// A trial for each checkpoint of the run.
std::vector<Trial> one_run(Stage& stage, const std::string& mode, std::uint32_t seed, double until,
                           const Reference& reference) {
  Renderer& renderer = stage.renderer();
  for (int warm = 0; warm < 2; ++warm) renderer.render(whole_frame(stage, mode, 2, seed), true);
  std::vector<Trial> trials;
  Trial trial;
  do {
    ++trial.frames;
    const Clock begin = now();
    const FrameStats stats = renderer.render(whole_frame(stage, mode, kRunSamples, seed), true);
    trial.time = trial.time + (now() - begin);
    const std::size_t samples = trial.stats.shading_samples + stats.shading_samples;
    trial.stats = stats;
    trial.stats.shading_samples = samples;
    add_frame(stats, &trial);
    if (!is_checkpoint(trial.frames)) continue;
    trial.error = error_against(renderer.read_radiance(), reference);
    trials.push_back(trial);
  } while (trials.back().error >= until && 0.5 * trial.time.cpu_ms <= 1e3 * stage.options().sweep_seconds);
  return trials;
}

/// Frames this short are repeated so many times more often, so that a disturbance by another program does not become
/// the median.
constexpr double kQuick_ms = 150.0;
constexpr int kQuickRepeats = 3;

}  // namespace

std::vector<Curve> accumulate(Stage& stage, const std::vector<std::string>& modes, double until,
                              const Reference& reference) {
  std::vector<std::vector<std::vector<Trial>>> trials(modes.size());  // [mode][checkpoint][repeat]
  for (int repeat = 0; repeat < stage.options().repeats; ++repeat)
    for (std::size_t m = 0; m < modes.size(); ++m) {
      const std::vector<Trial> run =
          one_run(stage, modes[m], static_cast<std::uint32_t>(11 + repeat), until, reference);
      if (trials[m].size() < run.size()) trials[m].resize(run.size());
      for (std::size_t k = 0; k < run.size(); ++k) trials[m][k].push_back(run[k]);
    }
  std::vector<Curve> curves(modes.size());
  for (std::size_t m = 0; m < modes.size(); ++m)
    for (const std::vector<Trial>& repeats : trials[m]) {
      curves[m].push_back(summarise(repeats, kRunSamples, repeats.front().frames));
      curves[m].back().accumulated = true;
      log_point(stage.current().name, modes[m], curves[m].back());
    }
  return curves;
}

std::optional<double> time_to(const Curve& curve, double error, bool cpu) {
  std::optional<double> least;
  for (const Curve& e : lower_envelopes(curve, cpu))
    for (std::size_t i = 0; i < e.size(); ++i) {
      if (e[i].error > error) continue;
      const double time = i == 0
                              ? e[0].time(cpu)
                              : interpolate_log(error, e[i - 1].error, e[i].error, e[i - 1].time(cpu), e[i].time(cpu));
      least = std::min(least.value_or(time), time);
      break;
    }
  return least;
}

std::optional<double> error_after(const Curve& curve, double time_ms, bool cpu) {
  std::optional<double> least;
  for (const Curve& e : lower_envelopes(curve, cpu)) {
    if (e.empty() || e.front().time(cpu) > time_ms) continue;
    double error = e.back().error;
    for (std::size_t i = 1; i < e.size(); ++i) {
      if (e[i].time(cpu) <= time_ms) continue;
      error = interpolate_log(time_ms, e[i - 1].time(cpu), e[i].time(cpu), e[i - 1].error, e[i].error);
      break;
    }
    least = std::min(least.value_or(error), error);
  }
  return least;
}

std::vector<Curve> sweep(Stage& stage, const std::vector<std::string>& modes, double until) {
  const Reference& reference = stage.reference();
  std::vector<Curve> curves(modes.size());
  std::vector<bool> done(modes.size(), false);
  for (int samples = 4; samples <= 4096; samples *= 2) {
    std::vector<std::vector<Trial>> trials(modes.size());
    const int repeats = stage.options().repeats;
    bool quick = repeats > 1;
    for (int repeat = 0; repeat < repeats || (quick && repeat < kQuickRepeats * repeats); ++repeat)
      for (std::size_t m = 0; m < modes.size(); ++m) {
        if (done[m]) continue;
        trials[m].push_back(one_frame(stage, modes[m], samples, static_cast<std::uint32_t>(11 + repeat), reference));
        quick = quick && trials[m].back().time.wall_ms < kQuick_ms;
      }
    for (std::size_t m = 0; m < modes.size(); ++m) {
      if (done[m]) continue;
      curves[m].push_back(summarise(trials[m], samples, 1));
      log_point(stage.current().name, modes[m], curves[m].back());
      done[m] = curves[m].back().error < until || curves[m].back().wall_ms > 1e3 * stage.options().sweep_seconds / 2.0;
    }
    if (std::all_of(done.begin(), done.end(), [](bool d) { return d; })) break;
  }
  const std::vector<Curve> more = accumulate(stage, modes, until, reference);
  for (std::size_t m = 0; m < modes.size(); ++m) curves[m].insert(curves[m].end(), more[m].begin(), more[m].end());
  return curves;
}

}  // namespace maquette::bench
