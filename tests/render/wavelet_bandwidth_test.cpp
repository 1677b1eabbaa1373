#include "render/environment/wavelet_bandwidth.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <numeric>
#include <random>
#include <vector>

namespace maquette {
namespace {

TEST(WaveletBandwidth, TransformKeepsEnergyAndKillsRamps) {
  std::mt19937 random(3);
  std::normal_distribution<float> normal;
  std::vector<float> signal(64), low(32), detail(32);
  for (float& v : signal) v = normal(random);
  d4_low_pass(signal.data(), 64, 1, 2, low.data());
  d4_detail(signal.data(), 64, 1, 2, detail.data());
  double before = 0.0, after = 0.0;
  for (const float v : signal) before += static_cast<double>(v) * static_cast<double>(v);
  for (std::size_t i = 0; i < 32; ++i) after += static_cast<double>(low[i] * low[i] + detail[i] * detail[i]);
  EXPECT_NEAR(after / before, 1.0, 1e-5);
  for (std::size_t i = 0; i < 64; ++i) signal[i] = 3.0f + 0.5f * static_cast<float>(i);
  d4_detail(signal.data(), 64, 1, 2, detail.data());
  for (std::size_t i = 0; i + 1 < 32; ++i)
    EXPECT_NEAR(detail[i], 0.0f, 1e-4f);  // the last one contains the jump at the period
}

TEST(WaveletBandwidth, LevelEnergiesFollowTheResponseEverywhere) {
  LevelEnergies energies(1024, 7);
  for (const double cycles : {5.0, 16.0, 37.0, 64.0, 90.0, 128.0, 200.0}) {
    for (std::size_t i = 0; i < 1024; ++i)
      energies.signal()[i] = static_cast<float>(
          std::sqrt(2.0) * std::cos(2.0 * std::numbers::pi * cycles * static_cast<double>(i) / 1024.0 + 0.4));
    energies.transform();
    const std::vector<double> expected = d4_response(cycles / 1024.0, 7);
    for (std::size_t begin = 0; begin < 1024; begin += 4)
      for (int level = 1; level <= 7; ++level)
        ASSERT_NEAR(energies.energy(level, begin, 4), expected[static_cast<std::size_t>(level - 1)], 0.2)
            << cycles << ' ' << level << ' ' << begin;
  }
}

TEST(WaveletBandwidth, LevelEnergiesAreWhereTheSignalIs) {
  LevelEnergies energies(1024, 7);
  std::fill(energies.signal().begin(), energies.signal().end(), 0.0f);
  energies.signal()[500] = 1.0f;
  energies.transform();
  for (int level = 1; level <= 7; ++level) {
    std::size_t best = 0;
    for (std::size_t begin = 0; begin < 1024; ++begin)
      if (energies.energy(level, begin, 1) > energies.energy(level, best, 1)) best = begin;
    EXPECT_NEAR(static_cast<double>(best), 500.0, static_cast<double>(std::size_t{2} << level)) << level;
  }
}

TEST(WaveletBandwidth, QuantileOfAToneIsItsFrequency) {
  const LevelSpectrum spectrum(9);
  for (double f = 1.0 / 200.0; f < 0.24; f *= 1.07) {
    std::vector<float> energies;
    double total = 0.0;
    for (const double share : d4_response(f, 9)) {
      energies.push_back(static_cast<float>(share));
      total += share;
    }
    std::vector<float> bins(spectrum.bin_count());
    const double negligible = 0.0;
    spectrum.spectra(energies.data(), &negligible, 1, bins.data());
    EXPECT_NEAR(std::accumulate(bins.begin(), bins.end(), 0.0) / total, 1.0, 1e-4);
    EXPECT_NEAR(spectrum.quantile(bins.data(), 0.05 * total) / f, 1.08, 0.1) << f;
    EXPECT_EQ(spectrum.quantile(bins.data(), 1.001 * total), 0.0);
  }
}

}  // namespace
}  // namespace maquette
