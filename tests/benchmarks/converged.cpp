// Accuracy of the converged pictures: their own noise, and whether `uniform`, which only samples, converges to them.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "tests/benchmarks/stage.h"

namespace maquette::bench {
namespace {

constexpr int kSeeds = 16, kSamples = 1024;

/// Mean of `uniform` pictures of independent seeds, and the variance of that mean.
struct Sampled {
  Image mean, variance;
};

Sampled sample_uniform(Stage& stage) {
  Sampled s{Image(stage.current().width, stage.current().height, 4), Image()};
  s.variance = s.mean;
  for (std::uint32_t seed = 0; seed < kSeeds; ++seed) {
    const Image part = stage.draw_uniform(kSamples, 500 + seed);
    for (std::size_t i = 0; i < part.data.size(); ++i) {
      s.mean.data[i] += part.data[i] / kSeeds;
      s.variance.data[i] += part.data[i] * part.data[i] / kSeeds;
    }
  }
  for (std::size_t i = 0; i < s.mean.data.size(); ++i)
    s.variance.data[i] = std::max(0.0f, s.variance.data[i] - s.mean.data[i] * s.mean.data[i]) / (kSeeds - 1);
  return s;
}

std::vector<std::size_t> covered_pixels(const Image& picture) {
  std::vector<std::size_t> pixels;
  for (std::size_t i = 0; i < picture.data.size(); i += 4)
    if (picture.data[i + 3] >= 1.0f) pixels.push_back(i);
  return pixels;
}

/// Prints the brightest parts of the picture, under a mirrored sun, where a bias of the estimator or of the quadrature
/// would show.
void log_brightest(const Image& picture, const Sampled& sampled, std::vector<std::size_t> pixels, double mean) {
  std::sort(pixels.begin(), pixels.end(),
            [&](std::size_t a, std::size_t b) { return picture.data[a + 1] > picture.data[b + 1]; });
  pixels.resize(std::min<std::size_t>(pixels.size(), 6));
  for (const std::size_t i : pixels) {
    const double value = picture.data[i + 1];
    std::fprintf(stderr, "  %4zu %4zu  picture %.5g x mean; uniform / picture %.5f +- %.5f\n",
                 i / 4 % static_cast<std::size_t>(picture.width), i / 4 / static_cast<std::size_t>(picture.width),
                 value / mean, sampled.mean.data[i + 1] / value,
                 std::sqrt(static_cast<double>(sampled.variance.data[i + 1])) / value);
  }
}

Figure judge_picture(const std::string& name, const Reference& reference, const Sampled& sampled) {
  const Image& picture = reference.picture;
  const std::vector<std::size_t> pixels = covered_pixels(picture);
  double mean = 0.0, brightest = 0.0, difference = 0.0, expected = 0.0;
  for (const std::size_t i : pixels)
    for (std::size_t k = i; k < i + 3; ++k) {
      mean += picture.data[k];
      brightest = std::max<double>(brightest, picture.data[k]);
      difference += std::pow(static_cast<double>(sampled.mean.data[k]) - picture.data[k], 2.0);
      expected += sampled.variance.data[k];
    }
  const double count = 3.0 * static_cast<double>(std::max<std::size_t>(pixels.size(), 1));
  mean /= count;
  log_brightest(picture, sampled, pixels, mean);
  const auto percent = [&](double square) { return number(100.0 * std::sqrt(square / count) / mean) + " %"; };
  return judged("converged picture, " + name, "noise <= 0.3 %",
                "noise " + number(100.0 * reference.noise) + " %, brightest " + number(brightest / mean) +
                    " times the mean; uniform differs by " + percent(difference) + " after " +
                    std::to_string(kSeeds * kSamples) + " samples, expected of its own noise " + percent(expected),
                reference.noise <= 0.003);
}

}  // namespace

Figures measure_converged(Stage& stage) {
  Figures figures;
  for (const Case& c : quality_cases(stage.options())) {
    if (!stage.options().wants(c.name)) continue;
    stage.show(c);
    const Reference reference = stage.reference();
    figures.push_back(judge_picture(c.name, reference, sample_uniform(stage)));
  }
  return figures;
}

}  // namespace maquette::bench
