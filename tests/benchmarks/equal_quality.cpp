// Time to equal error of `bandwidth` and `uniform`, and the figures of a research renderer under Grace Cathedral.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/benchmarks/stage.h"
#include "tests/benchmarks/sweep.h"

namespace maquette::bench {
namespace {

double geometric_mean(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double v : values) sum += std::log(v);
  return values.empty() ? 0.0 : std::exp(sum / static_cast<double>(values.size()));
}

/// The point of a curve whose error is nearest to `error` by ratio.
const SweepPoint& nearest(const Curve& curve, double error) {
  return *std::min_element(curve.begin(), curve.end(), [error](const SweepPoint& a, const SweepPoint& b) {
    return std::abs(std::log(a.error / error)) < std::abs(std::log(b.error / error));
  });
}

struct Sums {
  std::vector<double> wall_ratio, cpu_ratio, prediction, cpu_prediction, throughput, cpu_throughput;
  double least = 1e30;
  std::string least_at = "nowhere";
  int bounds = 0;  ///< ratios that are lower bounds
  bool all_reached = true;
};

/// Time to an error, or the time after which the mode had not reached it.
struct TimeTo {
  double ms = 0.0;
  bool reached = true;
  std::string text() const { return (reached ? "" : "more than ") + number(ms) + " ms"; }
};

TimeTo time_or_bound(const Curve& curve, double error, bool cpu) {
  if (const auto ms = time_to(curve, error, cpu)) return {*ms, true};
  double longest = 0.0;
  for (const SweepPoint& p : curve) longest = std::max(longest, p.time(cpu));
  return {longest, false};
}

void judge_case(const Case& c, double noise, const Curve& uniform, const Curve& bandwidth, Sums* sums,
                Figures* figures) {
  for (const double error : {0.01, 0.02, 0.05, 0.1}) {
    const std::string name = "equal quality, " + c.name + ", to " + percent(error);
    if (error < noise) {
      figures->push_back(absent(name, "", "the converged picture's own noise is " + percent(noise)));
      if (error == 0.02) sums->all_reached = false;
      continue;
    }
    // If uniform did not reach the error in its time, the ratio is a lower bound.
    const TimeTo u = time_or_bound(uniform, error, false), b = time_or_bound(bandwidth, error, false);
    const TimeTo uc = time_or_bound(uniform, error, true), bc = time_or_bound(bandwidth, error, true);
    std::string text = "uniform " + u.text() + ", bandwidth " + b.text();
    if (b.reached)
      text += std::string(": ") + (u.reached ? "" : "at least ") + number(u.ms / b.ms) + " x (CPU " +
              number(uc.ms / bc.ms) + " x)";
    figures->push_back(shown(name, text));
    if (error != 0.02) continue;
    if (b.reached) {
      sums->wall_ratio.push_back(u.ms / b.ms);
      sums->cpu_ratio.push_back(uc.ms / bc.ms);
      sums->bounds += u.reached ? 0 : 1;
    } else {
      sums->all_reached = false;
    }
    if (const auto e = error_after(bandwidth, u.ms, false))
      figures->push_back(shown("equal time, " + c.name + ", when uniform has " +
                                   (u.reached ? "2 %" : percent(error_after(uniform, u.ms, false).value_or(0.0))),
                               "bandwidth has " + percent(*e)));
    const SweepPoint& p = nearest(bandwidth, error);
    sums->prediction.push_back(p.prediction_ms / std::max(p.frame_ms, 1e-9));
    sums->cpu_prediction.push_back(p.prediction_cpu_ms / std::max(p.cpu_ms, 1e-9));
  }
  for (const double error : {0.01, 0.015, 0.02, 0.03, 0.05, 0.07, 0.1}) {
    if (error < noise) continue;
    const TimeTo u = time_or_bound(uniform, error, true), b = time_or_bound(bandwidth, error, true);
    if (!u.reached && u.ms < b.ms) continue;  // a bound below 1 says nothing
    const double ratio = b.reached ? u.ms / b.ms : u.reached ? 0.0 : 1e30;
    if (ratio < sums->least) {
      sums->least = ratio;
      sums->least_at = c.name + " at " + percent(error);
    }
  }
  const SweepPoint& longest =
      *std::max_element(uniform.begin(), uniform.end(),
                        [](const SweepPoint& a, const SweepPoint& b) { return a.shading_samples < b.shading_samples; });
  sums->throughput.push_back(longest.shading_samples / longest.frame_ms * 1e-3);
  sums->cpu_throughput.push_back(longest.shading_samples / (0.5 * longest.cpu_ms) * 1e-3);
}

}  // namespace

Figures measure_equal_quality(Stage& stage) {
  Figures figures;
  Sums sums;
  for (const Case& c : quality_cases(stage.options())) {
    if (!stage.options().wants(c.name)) continue;
    stage.show(c);
    const double noise = stage.reference().noise;
    std::fprintf(stderr, "  %-16s reference noise %.2f %%\n", c.name.c_str(), 100.0 * noise);
    const std::vector<Curve> curves = sweep(stage, {"uniform", "bandwidth"}, 0.009);
    figures.push_back(shown("reference noise, " + c.name, percent(noise)));
    judge_case(c, noise, curves[0], curves[1], &sums, &figures);
  }
  if (sums.throughput.empty()) return figures;
  const double ratio = geometric_mean(sums.wall_ratio);
  const std::string count = std::to_string(sums.wall_ratio.size()) + " cases";
  figures.push_back(judged("equal quality, time of uniform over bandwidth to 2 %", ">= 3 (aim 5)",
                           (sums.bounds > 0 ? "at least " : "") + number(ratio) + " x (geometric mean of " + count +
                               ", " + std::to_string(sums.bounds) +
                               " of them bounds because uniform did not get there; CPU time " +
                               number(geometric_mean(sums.cpu_ratio)) + " x)",
                           ratio >= 3.0 && sums.all_reached));
  figures.push_back(judged("equal quality, worst between 1 % and 10 %", ">= 0.9",
                           number(sums.least) + " x, " + sums.least_at, sums.least >= 0.9));
  const double least_rate = *std::min_element(sums.throughput.begin(), sums.throughput.end());
  figures.push_back(judged("uniform, million shading samples a second", ">= 30",
                           number(least_rate) + " to " +
                               number(*std::max_element(sums.throughput.begin(), sums.throughput.end())) +
                               " (by CPU time on two cores from " +
                               number(*std::min_element(sums.cpu_throughput.begin(), sums.cpu_throughput.end())) + ")",
                           least_rate >= 30.0));
  const double share = *std::max_element(sums.prediction.begin(), sums.prediction.end());
  figures.push_back(judged("prediction's share of the frame at 2 %", "<= 15 %",
                           percent(share) + " at most, " + percent(geometric_mean(sums.prediction)) + " mean (CPU " +
                               percent(*std::max_element(sums.cpu_prediction.begin(), sums.cpu_prediction.end())) +
                               " and " + percent(geometric_mean(sums.cpu_prediction)) + ")",
                           share <= 0.15));
  return figures;
}

Figures measure_progressive(Stage& stage) {
  Figures figures;
  double least = 1e30;
  std::string least_at = "nowhere";
  for (const Case& c : quality_cases(stage.options())) {
    if (!stage.options().wants(c.name)) continue;
    stage.show(c);
    const Reference& reference = stage.reference();
    const std::vector<Curve> curves = accumulate(stage, {"uniform", "bandwidth"}, 0.005, reference);
    const Curve &uniform = curves[0], &bandwidth = curves[1];
    std::string text;
    for (const SweepPoint& p : uniform) {
      const auto e = error_after(bandwidth, p.cpu_ms, true);
      if (!e || p.error < reference.noise) continue;
      text += (text.empty() ? "" : ", ") + number(1e-3 * p.cpu_ms) + " s: " + percent(p.error) + " and " + percent(*e);
      if (p.error / *e < least) {
        least = p.error / *e;
        least_at = c.name + " after " + number(1e-3 * p.cpu_ms) + " s";
      }
    }
    figures.push_back(shown("errors of uniform and bandwidth after CPU time, " + c.name, text));
  }
  figures.push_back(judged("progressive error of uniform over bandwidth's at the same time", ">= 1 everywhere",
                           "at least " + number(least) + ", " + least_at, least >= 1.0));
  return figures;
}

Figures measure_research(Stage& stage) {
  Figures figures;
  const std::string target = "<= 1 s";
  if (stage.options().data.empty()) return {absent("to 2 % under Grace Cathedral", target, "needs --data")};
  for (const Case& c : research_cases(stage.options())) {
    if (!stage.options().wants(c.name)) continue;
    stage.show(c);
    const double noise = stage.reference().noise;
    const Curve curve = sweep(stage, {"bandwidth"}, 0.018)[0];
    const auto wall = time_to(curve, 0.02, false), cpu = time_to(curve, 0.02, true);
    const std::string name = "512 x 512 sphere to 2 %, " + c.name;
    const std::string tail = ", reference noise " + percent(noise);
    if (noise > 0.02)
      figures.push_back(absent(name, target, "the converged picture's own noise is " + percent(noise)));
    else if (wall)
      figures.push_back(
          judged(name, target, number(*wall) + " ms (CPU " + number(*cpu) + " ms)" + tail, *wall <= 1000.0));
    else
      figures.push_back(judged(name, target, "not reached; best " + percent(nearest(curve, 1e-6).error) + tail, false));
  }
  return figures;
}

}  // namespace maquette::bench
