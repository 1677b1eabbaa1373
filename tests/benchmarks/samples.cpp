// Quality of one shading sample of the estimator: its standard deviation over seeds, and its time.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "scenes/luminance.h"
#include "tests/benchmarks/stage.h"
#include "tests/support/local_bandwidth.h"

namespace maquette::bench {
namespace {

constexpr int kSamples = 64, kSeeds = 24;

/// Variances of the luminance of single frames, one for each pixel with light; their mean luminance; time of a frame.
struct Spread {
  std::vector<double> variance;
  double mean = 0.0, shading_samples = 0.0;
  std::vector<double> cpu_ms;
};

Spread measure_spread(Stage& stage) {
  const auto count = static_cast<std::size_t>(stage.current().width * stage.current().height);
  std::vector<double> mean(count, 0.0), square(count, 0.0);
  Spread s;
  stage.renderer().render(stage.request("uniform", kSamples));
  for (int seed = 0; seed < kSeeds; ++seed) {
    const Clock begin = now();
    const FrameStats stats =
        stage.renderer().render(stage.request("uniform", kSamples, 301u + static_cast<unsigned>(seed)));
    s.cpu_ms.push_back((now() - begin).cpu_ms);
    s.shading_samples = static_cast<double>(stats.shading_samples);
    const Image p = stage.renderer().read_radiance();
    for (std::size_t i = 0; i < count; ++i) {
      const float* rgb = &p.data[4 * i];
      const double y = luminance(glm::dvec3(rgb[0], rgb[1], rgb[2])), d = y - mean[i];
      mean[i] += d / (seed + 1);
      square[i] += d * (y - mean[i]);
    }
  }
  for (std::size_t i = 0; i < count; ++i) {
    if (square[i] <= 0.0) continue;  // sky, or no random choice
    s.variance.push_back(square[i] / (kSeeds - 1));
    s.mean += mean[i];
  }
  s.mean /= std::max<double>(static_cast<double>(s.variance.size()), 1.0);
  return s;
}

/// Standard deviation of one sample over the mean luminance, without the noisiest `left_out` of the pixels.
double deviation(const Spread& s, double left_out) {
  std::vector<double> sorted = s.variance;
  std::sort(sorted.begin(), sorted.end());
  const auto kept = static_cast<std::size_t>((1.0 - left_out) * static_cast<double>(sorted.size()));
  double sum = 0.0;
  for (std::size_t i = 0; i < kept; ++i) sum += sorted[i];
  return std::sqrt(kSamples * sum / std::max<double>(static_cast<double>(kept), 1.0)) / s.mean;
}

}  // namespace

Figures measure_samples(Stage& stage) {
  std::vector<Case> cases = quality_cases(stage.options());
  for (Case& c : research_cases(stage.options())) cases.push_back(std::move(c));
  Figures figures;
  for (Case& c : cases) {
    if (!stage.options().wants(c.name)) continue;
    c.width /= 2;
    c.height /= 2;
    stage.show(c);
    const Spread s = measure_spread(stage);
    const double ns = 1e6 * test::median(s.cpu_ms) / s.shading_samples, all = deviation(s, 0.0);
    figures.push_back(shown("one sample, " + c.name,
                            "deviation " + number(all) + " of the mean, " + number(deviation(s, 0.001)) + " and " +
                                number(deviation(s, 0.01)) + " without the noisiest 0.1 and 1 % of the pixels; " +
                                number(ns) + " ns of processor time, frame included"));
    std::fprintf(stderr, "  %-28s %s\n", c.name.c_str(), figures.back().measured.c_str());
  }
  return figures;
}

}  // namespace maquette::bench
