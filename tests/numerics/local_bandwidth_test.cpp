#include "tests/support/local_bandwidth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <glm/glm.hpp>
#include <numbers>
#include <random>

namespace maquette::test {
namespace {

Image make_picture(int width, int height, const std::function<double(int, int)>& value) {
  Image image(width, height, 4, 1.0f);
  for (int y = 0; y < height; ++y)
    for (int x = 0; x < width; ++x)
      for (int c = 0; c < 3; ++c) image.at(x, y, c) = static_cast<float>(value(x, y));
  return image;
}

TEST(LocalBandwidth, WaveHasItsFrequencyAlongItsAxis) {
  for (const double frequency : {0.05, 0.08, 0.15, 0.3, 0.45}) {
    const Image image =
        make_picture(64, 64, [&](int x, int) { return 2.0 + std::cos(2.0 * std::numbers::pi * frequency * x); });
    const auto windows = measure_local_bandwidth(image, image, std::vector<bool>(64 * 64, true), {});
    ASSERT_EQ(windows.size(), 25u);
    for (const WindowBandwidth& w : windows) {
      EXPECT_NEAR(w.nu_x, frequency, 0.0015);
      EXPECT_LT(w.nu_y, 0.012);  // only the window's own width, after correction
    }
  }
}

TEST(LocalBandwidth, IsLocal) {
  const Image image = make_picture(
      128, 64, [](int x, int) { return 2.0 + std::cos(2.0 * std::numbers::pi * (x < 64 ? 0.05 : 0.25) * x); });
  for (const WindowBandwidth& w : measure_local_bandwidth(image, image, std::vector<bool>(128 * 64, true), {})) {
    if (w.x <= 48) {
      EXPECT_LT(w.nu_x, 0.09) << w.x;
    } else if (w.x >= 80) {
      EXPECT_GT(w.nu_x, 0.23) << w.x;
    }
  }
}

TEST(LocalBandwidth, WhiteNoiseFillsTheBand) {
  unsigned state = 1;
  const Image image = make_picture(64, 64, [&](int, int) {
    state = state * 1664525u + 1013904223u;
    return static_cast<double>(state >> 8) / 16777216.0;
  });
  for (const WindowBandwidth& w : measure_local_bandwidth(image, image, std::vector<bool>(64 * 64, true), {}))
    EXPECT_NEAR(w.nu_x, 0.475 - 0.03, 0.02);  // 95 % of all frequencies, less the excess that a wave reads
  LocalBandwidthOptions quadrature;
  quadrature.undo_window = UndoWindow::quadrature;
  for (const WindowBandwidth& w : measure_local_bandwidth(image, image, std::vector<bool>(64 * 64, true), quadrature))
    EXPECT_NEAR(w.nu_x, 0.475, 0.02);
}

/// Sums of waves of any phase and size: a signal limited to a bandwidth above the floor never reads much more than it.
TEST(LocalBandwidth, BandLimitedSignalsReadNoMore) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> u(0.0, 1.0);
  const LocalBandwidthOptions options;
  const double floor = measured_floor(options);
  int above = 0, windows = 0;
  for (int trial = 0; trial < 200; ++trial) {
    const double limit = floor + 0.25 * u(random);
    std::array<glm::dvec3, 6> waves{};
    for (glm::dvec3& wave : waves) wave = {limit * u(random), 2.0 * std::numbers::pi * u(random), u(random)};
    const Image image = make_picture(32, 32, [&](int x, int) {
      double sum = 10.0;
      for (const glm::dvec3& wave : waves) sum += wave.z * std::cos(2.0 * std::numbers::pi * wave.x * x + wave.y);
      return sum;
    });
    for (const WindowBandwidth& w : measure_local_bandwidth(image, image, std::vector<bool>(32 * 32, true), options)) {
      EXPECT_LT(w.nu_x, limit + 0.02);
      above += w.nu_x > limit * 1.02;
      ++windows;
    }
  }
  EXPECT_LT(above, windows / 20);
}

TEST(LocalBandwidth, WavesLongerThanAWindowMeasureTheFloor) {
  const LocalBandwidthOptions options;
  for (const double period : {34.0, 64.0, 100.0, 400.0}) {
    const Image image =
        make_picture(320, 32, [&](int x, int) { return 2.0 + std::cos(2.0 * std::numbers::pi * x / period); });
    double largest = 0.0;
    for (const WindowBandwidth& w : measure_local_bandwidth(image, image, std::vector<bool>(320 * 32, true), options))
      largest = std::max(largest, w.nu_x);
    EXPECT_LE(largest, 1.001 * measured_floor(options)) << period;
    EXPECT_GT(largest, 0.5 * measured_floor(options)) << period;
  }
}

TEST(LocalBandwidth, IndependentNoiseIsNoBandwidth) {
  unsigned state = 1;
  const auto noisy = [&](int x, int) {
    state = state * 1664525u + 1013904223u;
    return 2.0 + std::cos(2.0 * std::numbers::pi * 0.1 * x) +
           0.6 * (static_cast<double>(state >> 8) / 16777216.0 - 0.5);
  };
  const Image a = make_picture(64, 64, noisy), b = make_picture(64, 64, noisy);
  for (const WindowBandwidth& w : measure_local_bandwidth(a, b, std::vector<bool>(64 * 64, true), {})) {
    EXPECT_NEAR(w.nu_x, 0.1, 0.05);
    EXPECT_GT(w.noise, 0.01);
    EXPECT_LT(w.noise, 0.1);
  }
}

/// Half of the window is constant at the wave's mean: its spectrum is that of the wave, and so the prediction has to be
/// weighted towards the wave.
TEST(LocalBandwidth, PredictionsAreWeightedByVariation) {
  const auto wave = [](int x) {  // fades in, so that its beginning is no edge
    const double fade = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * (x + 0.5 - 16) / 16.0);
    return x < 16 ? 0.0 : fade * std::cos(2.0 * std::numbers::pi * 0.2 * x);
  };
  const Image image = make_picture(32, 32, [&](int x, int) { return 10.0 + wave(x); });
  const Image prediction = make_picture(32, 32, [](int x, int) { return x < 16 ? 0.0 : 0.2; });
  const auto windows = measure_local_bandwidth(image, image, std::vector<bool>(32 * 32, true), {});
  ASSERT_EQ(windows.size(), 1u);
  const auto pooled = [&](Pooling p) { return pooled_prediction(prediction, image, windows[0], 32, p); };
  EXPECT_NEAR(windows[0].nu_x, 0.2, 0.06);
  EXPECT_NEAR(pooled(Pooling::variation), 0.2, 0.001);
  EXPECT_NEAR(pooled(Pooling::light), 0.1, 0.01);
  EXPECT_NEAR(pooled(Pooling::mean), 0.1, 1e-6);
  EXPECT_FLOAT_EQ(static_cast<float>(pooled(Pooling::largest)), 0.2f);
}

TEST(LocalBandwidth, LeavesOutWindowsWithExcludedPixels) {
  std::vector<bool> usable(64 * 64, true);
  usable[20 * 64 + 20] = false;
  const Image image = make_picture(64, 64, [](int, int) { return 1.0; });
  const auto windows = measure_local_bandwidth(image, image, usable, {});
  for (const WindowBandwidth& w : windows) EXPECT_TRUE(w.x - 16 > 20 || w.y - 16 > 20);
  EXPECT_EQ(windows.size(), 25u - 9u);
}

/// Waves of known length: below the floor of 32 pixels they can still be told apart, below the floor of all scales they
/// read the floor.
TEST(LocalBandwidth, ScalesTellLongWaves) {
  const std::vector<bool> all(160 * 160, true);
  double before = 0.0;
  for (const double frequency : {0.018, 0.025, 0.035, 0.06, 0.12, 0.25}) {
    const Image image =
        make_picture(160, 160, [&](int, int y) { return 2.0 + std::cos(2.0 * std::numbers::pi * frequency * y); });
    double largest = 0.0;
    for (const ScaledBandwidth& s : measure_scaled_bandwidth(image, image, all, WindowFilter::off_longest)) {
      EXPECT_NEAR(s.bandwidth.nu_y, frequency, 0.2 * frequency);  // short windows read their longest waves a little off
      largest = std::max(largest, s.bandwidth.nu_y);
    }
    EXPECT_GT(largest, 1.1 * before) << frequency;
    before = largest;
  }
  const Image slow =
      make_picture(160, 160, [](int, int y) { return 2.0 + std::cos(2.0 * std::numbers::pi * 0.004 * y); });
  for (const ScaledBandwidth& s : measure_scaled_bandwidth(slow, slow, all, WindowFilter::off_longest)) {
    EXPECT_LE(s.bandwidth.nu_y, kScaledFloor);
    EXPECT_EQ(s.window, 128);
  }
}

/// Noise limited to a disc of frequencies, reflected by a sphere, a dent, a fold: its bandwidth at a pixel is that of
/// the noise times the stretch of the mapping.
TEST(LocalBandwidth, ScalesMeasureWarpedNoise) {
  constexpr int kSide = 160;
  constexpr double kBoxOfDisc = 0.805;  // 95 % of a disc's area lies within this share of its radius along an axis
  const auto sphere = [](glm::dvec2 p) {
    const glm::dvec2 d = (p - 80.0) / 100.0;
    const double r = glm::length(d) + 1e-9;
    return d / r * (2.0 * std::asin(std::min(r, 0.999)));
  };
  const auto dent = [](glm::dvec2 p) {
    const glm::dvec2 d = (p - 75.0) / 200.0;
    return d * (0.4 + 3.0 * std::exp(-40.0 * glm::dot(d, d)));
  };
  const auto fold = [](glm::dvec2 p) {
    const glm::dvec2 d = p / 160.0;
    return glm::dvec2(0.2 * d.x + 0.3 * std::tanh(8.0 * (d.x - 0.5)), 0.2 * d.y);
  };
  std::mt19937 random(5);
  std::uniform_real_distribution<double> u(-1.0, 1.0);
  std::vector<double> exact, measured, ratios;
  for (const std::function<glm::dvec2(glm::dvec2)>& map :
       {std::function<glm::dvec2(glm::dvec2)>(sphere), {dent}, {fold}})
    for (const double radius : {6.0, 30.0}) {
      std::vector<glm::dvec3> waves;
      while (waves.size() < 60) {
        const glm::dvec2 f(u(random), u(random));
        if (glm::dot(f, f) <= 1.0) waves.emplace_back(radius * f, std::numbers::pi * u(random));
      }
      const Image image = make_picture(kSide, kSide, [&](int x, int y) {
        const glm::dvec2 p = map({x, y});
        double sum = 200.0;
        for (const glm::dvec3& w : waves) sum += std::cos(2.0 * std::numbers::pi * (w.x * p.x + w.y * p.y) + w.z);
        return sum;
      });
      const Image known = make_picture(kSide, kSide, [&](int x, int y) {
        const glm::dvec2 p(x, y), dx(0.5, 0.0), dy(0.0, 0.5);
        return kBoxOfDisc * radius *
               std::max(glm::length(map(p + dx) - map(p - dx)), glm::length(map(p + dy) - map(p - dy)));
      });
      for (const ScaledBandwidth& s :
           measure_scaled_bandwidth(image, image, std::vector<bool>(kSide * kSide, true), WindowFilter::off_longest)) {
        exact.push_back(
            std::max(kScaledFloor, pooled_prediction(known, image, s.bandwidth, s.window, Pooling::variation)));
        measured.push_back(std::max({kScaledFloor, s.bandwidth.nu_x, s.bandwidth.nu_y}));
        ratios.push_back(exact.back() / measured.back());
      }
    }
  EXPECT_GT(rank_correlation(exact, measured), 0.9);
  EXPECT_NEAR(median(ratios), 1.0, 0.15);
  EXPECT_LT(percentile(ratios, 0.9), 1.7);
  EXPECT_GT(percentile(ratios, 0.1), 0.7);
}

/// A step with twice the blur has half the bandwidth, at every size between the floor and the grid.
TEST(LocalBandwidth, ScalesFollowTheBlurOfAStep) {
  const std::vector<bool> all(160 * 160, true);
  double before = 0.0;
  for (const double sigma : {8.0, 4.0, 2.0}) {
    const Image image =
        make_picture(160, 160, [&](int x, int) { return 2.0 + std::erf((x - 79.5) / (std::numbers::sqrt2 * sigma)); });
    double nearest = 0.0;
    for (const ScaledBandwidth& s : measure_scaled_bandwidth(image, image, all, WindowFilter::off_longest))
      if (s.bandwidth.x == 80) nearest = std::max(nearest, s.bandwidth.nu_x);
    if (before > 0.0) {
      EXPECT_NEAR(nearest / before, 2.0, 0.5) << sigma;
    }
    before = nearest;
  }
}

TEST(LocalBandwidth, ScalesFollowTheWindowFilter) {
  // Usable for windows of 128 pixels in the left half; in the right one a gap leaves room for windows of 32.
  std::vector<bool> usable(320 * 128, true);
  for (int y = 0; y < 128; ++y) usable[static_cast<std::size_t>(y * 320 + 240)] = false;
  const Image wave =
      make_picture(320, 128, [](int x, int) { return 2.0 + std::cos(2.0 * std::numbers::pi * 0.2 * x); });
  const auto on_right = [&](WindowFilter filter) {
    int count = 0;
    for (const ScaledBandwidth& s : measure_scaled_bandwidth(wave, wave, usable, filter)) {
      EXPECT_GT(std::abs(s.bandwidth.x + 0.5 - 240.5) + 0.5, 0.5 * s.window);
      EXPECT_LE(s.window, 32);
      count += s.bandwidth.x > 240;
    }
    return count;
  };
  EXPECT_EQ(on_right(WindowFilter::off_longest), 0);
  EXPECT_GT(on_right(WindowFilter::off_own), 50);
}

TEST(LocalBandwidth, FindsGeometricEdges) {
  // A slanted plane, with a step in depth at x = 20 and a change of material at x = 40.
  Image depth(64, 16, 4, 1.0f), normal(64, 16, 4, 1.0f), material(64, 16, 4, 1.0f);
  for (int y = 0; y < 16; ++y)
    for (int x = 0; x < 64; ++x) {
      depth.at(x, y) = 1.0f / (0.2f + 0.003f * static_cast<float>(x)) + (x >= 20 ? 1.0f : 0.0f);
      material.at(x, y) = x >= 40 ? 2.0f : 1.0f;
      for (int c = 0; c < 3; ++c) normal.at(x, y, c) = c == 2 ? 1.0f : 0.0f;
    }
  const std::vector<bool> smooth = smooth_surface_pixels(depth, normal, material);
  for (int x = 1; x < 63; ++x)
    EXPECT_EQ(smooth[static_cast<std::size_t>(8 * 64 + x)], x != 19 && x != 20 && x != 39 && x != 40) << x;
}

TEST(RankCorrelation, KnowsOrderAndTies) {
  EXPECT_DOUBLE_EQ(rank_correlation({1, 2, 3, 4}, {10, 20, 300, 4000}), 1.0);
  EXPECT_DOUBLE_EQ(rank_correlation({1, 2, 3, 4}, {4, 3, 2, 1}), -1.0);
  // By hand: ranks 0.5 0.5 2 3 and 0 1 2 3 give 4.5 / sqrt(4.5 * 5).
  EXPECT_NEAR(rank_correlation({1, 1, 2, 3}, {1, 2, 3, 4}), std::sqrt(4.5 / 5.0), 1e-12);
  EXPECT_DOUBLE_EQ(rank_correlation({1, 1, 1}, {1, 2, 3}), 0.0);
}

TEST(Percentile, TakesTheNearestRank) {
  EXPECT_DOUBLE_EQ(median({5, 1, 3}), 3.0);
  EXPECT_DOUBLE_EQ(percentile({4, 1, 2, 3, 0}, 1.0), 4.0);
  EXPECT_DOUBLE_EQ(percentile({}, 0.5), 0.0);
}

}  // namespace
}  // namespace maquette::test
