#include "render/environment/wavelet_bandwidth.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>

#include "render/math/daubechies4.h"
#include "render/math/wide.h"

namespace maquette {
namespace {

constexpr int kBinsPerOctave = 4;
constexpr int kIterations = 60;
constexpr std::size_t kLanes = 8;
/// Eight spectra side by side in explicit SIMD vectors: automatic vectorisation takes the bins as lanes and needs
/// shuffles.
using Lanes = float __attribute__((vector_size(kLanes * sizeof(float))));
struct alignas(sizeof(Lanes)) Spectra {
  Lanes of;
};
constexpr double kNegligible = 1e-4;  ///< share of a tone in a level
/// The estimated peak's half width, in octaves (see the header).
constexpr double kPeakOctaves = 0.2;

void filter(const std::array<float, 4>& taps, const float* signal, std::size_t n, std::size_t dilation,
            std::size_t step, float* result) {
  const std::size_t inside = (n - 3 * dilation + step - 1) / step;  // from here on the taps wrap
#pragma omp simd
  for (std::size_t i = 0; i < inside; ++i) {
    const float* s = signal + i * step;
    result[i] = taps[0] * s[0] + taps[1] * s[dilation] + taps[2] * s[2 * dilation] + taps[3] * s[3 * dilation];
  }
  for (std::size_t i = inside; i * step < n; ++i) {
    float sum = 0.0f;
    for (std::size_t k = 0; k < 4; ++k) sum += taps[k] * signal[(i * step + k * dilation) % n];
    result[i] = sum;
  }
}

/// |H(f)|^2 / 2: share of a tone's energy that the low-pass keeps. The detail gets the rest.
double low_share(double frequency) {
  std::complex<double> sum = 0.0;
  for (int k = 0; k < 4; ++k)
    sum += static_cast<double>(kDaubechies4[k]) * std::polar(1.0, -2.0 * std::numbers::pi * frequency * k);
  return std::norm(sum) / 2.0;
}

/// Bin 0 is the highest: [2^-1.25, 2^-1] cycles per sample.
double bin_upper_log2(double bin) { return -1.0 - bin / kBinsPerOctave; }

}  // namespace

void d4_low_pass(const float* signal, std::size_t n, std::size_t dilation, std::size_t step, float* low) {
  filter({kDaubechies4[0], kDaubechies4[1], kDaubechies4[2], kDaubechies4[3]}, signal, n, dilation, step, low);
}

void d4_detail(const float* signal, std::size_t n, std::size_t dilation, std::size_t step, float* detail) {
  filter({kDaubechies4[3], -kDaubechies4[2], kDaubechies4[1], -kDaubechies4[0]}, signal, n, dilation, step, detail);
}

LevelEnergies::LevelEnergies(std::size_t n, int level_count) : signal_(n), low_(n), next_(n) {
  std::size_t spacing = 1;
  for (int level = 1; level <= level_count; ++level) {
    if (level > 2) spacing *= 2;
    spacing_.push_back(spacing);
    squares_.emplace_back(n / spacing);
  }
}

void LevelEnergies::transform() {
  std::size_t n = signal_.size();
  const float* current = signal_.data();
  for (std::size_t j = 0; j < squares_.size(); ++j) {
    const std::size_t dilation = j == 0 ? 1 : 2;
    d4_detail(current, n, dilation, 1, squares_[j].data());
    // An orthonormal coefficient of level j + 1 stands for 2^(j + 1) samples.
    const float scale = 1.0f / static_cast<float>(std::size_t{2} << j);
    for (float& c : squares_[j]) c *= c * scale;
    // The first low-pass stays as dense as the signal (twice critical), the later ones halve it.
    const std::size_t step = j == 0 ? 1 : 2;
    d4_low_pass(current, n, dilation, step, next_.data());
    std::swap(low_, next_);
    current = low_.data();
    n /= step;
  }
}

float LevelEnergies::energy(int level, std::size_t begin, std::size_t side) const {
  const auto j = static_cast<std::size_t>(level - 1);
  const std::vector<float>& squares = squares_[j];
  const std::size_t mask = squares.size() - 1;
  const std::size_t spacing = spacing_[j];
  const std::size_t coefficient = std::size_t{2} << j;
  const std::size_t count = std::max(side, 2 * coefficient) / spacing;
  // The coefficient at position p covers [p, p + 3 (coefficient / 2 ...)): its centre is 1.5 coefficients after p.
  const std::size_t middle = begin + side / 2 + 4 * signal_.size() - 3 * coefficient / 2;
  const std::size_t first = middle / spacing - count / 2;
  float sum = 0.0f;
  for (std::size_t i = 0; i < count; ++i) sum += squares[(first + i) & mask];
  return sum / static_cast<float>(count);
}

std::vector<double> d4_response(double frequency, int level_count) {
  std::vector<double> shares;
  double kept = 1.0;
  for (int j = 0; j < level_count; ++j, frequency *= 2.0) {
    const double low = low_share(frequency);
    shares.push_back(kept * (1.0 - low));
    kept *= low;
  }
  return shares;
}

struct LevelSpectrum::Group {
  std::vector<Spectra> energies;              ///< [level], relative to their sum
  std::vector<Spectra> spectrum, correction;  ///< [bin]
};

LevelSpectrum::LevelSpectrum(int level_count)
    : level_count_(static_cast<std::size_t>(level_count)), bin_count_((level_count_ + 1) * kBinsPerOctave) {
  response_.resize(level_count_ * bin_count_);
  gain_.assign(bin_count_, 0.0f);
  begin_.assign(level_count_, bin_count_);
  end_.assign(level_count_, 0);
  for (std::size_t b = 0; b < bin_count_; ++b) {
    const std::vector<double> shares =
        d4_response(std::exp2(bin_upper_log2(static_cast<double>(b) + 0.5)), level_count);
    for (std::size_t j = 0; j < shares.size(); ++j) {
      if (shares[j] < kNegligible) continue;
      response_[j * bin_count_ + b] = static_cast<float>(shares[j]);
      gain_[b] += static_cast<float>(shares[j]);
      begin_[j] = std::min(begin_[j], b);
      end_[j] = b + 1;
    }
  }
}

MAQUETTE_WIDE void LevelSpectrum::estimate(Group& group) const {
  for (Spectra& bin : group.spectrum) bin.of = Lanes{} + 1.0f / static_cast<float>(bin_count_);
  for (int iteration = 0; iteration < kIterations; ++iteration) {
    for (Spectra& bin : group.correction) bin.of = Lanes{};
    for (std::size_t j = 0; j < level_count_; ++j) {
      const float* response = &response_[j * bin_count_];
      Lanes ratio = Lanes{} + 1e-30f;
      for (std::size_t b = begin_[j]; b < end_[j]; ++b) ratio += group.spectrum[b].of * response[b];
      ratio = group.energies[j].of / ratio;
      for (std::size_t b = begin_[j]; b < end_[j]; ++b) group.correction[b].of += ratio * response[b];
    }
    for (std::size_t b = 0; b < bin_count_; ++b) group.spectrum[b].of *= group.correction[b].of * (1.0f / gain_[b]);
  }
}

void LevelSpectrum::spectra(const float* energies, const double* negligible, std::size_t count, float* result) const {
  Group group{std::vector<Spectra>(level_count_), std::vector<Spectra>(bin_count_), std::vector<Spectra>(bin_count_)};
  std::array<std::size_t, kLanes> members{};
  std::array<float, kLanes> totals{};
  std::size_t filled = 0;
  std::fill(result, result + count * bin_count_, 0.0f);
  const auto finish = [&] {
    if (filled == 0) return;
    estimate(group);
    for (std::size_t l = 0; l < filled; ++l)
      for (std::size_t b = 0; b < bin_count_; ++b)
        result[members[l] * bin_count_ + b] = group.spectrum[b].of[l] * gain_[b] * totals[l];
    filled = 0;
  };
  for (std::size_t i = 0; i < count; ++i) {
    double total = 0.0;
    for (std::size_t j = 0; j < level_count_; ++j) total += static_cast<double>(energies[i * level_count_ + j]);
    if (!(total > negligible[i])) continue;
    for (std::size_t j = 0; j < level_count_; ++j)
      group.energies[j].of[filled] = static_cast<float>(static_cast<double>(energies[i * level_count_ + j]) / total);
    members[filled] = i;
    totals[filled] = static_cast<float>(total);
    if (++filled == kLanes) finish();
  }
  finish();
}

double LevelSpectrum::bin_frequency(std::size_t bin) {
  return std::exp2(bin_upper_log2(static_cast<double>(bin) + 0.5));
}

double LevelSpectrum::quantile(const float* spectrum, double tail) const {
  double above = 0.0;
  for (std::size_t b = 0; b < bin_count_; ++b) {
    const double energy = static_cast<double>(spectrum[b]), missing = tail - above;
    above += energy;
    // `missing` of the bin's energy lies above the quantile, counted from the bin's upper edge.
    if (energy > missing) return std::exp2(bin_upper_log2(static_cast<double>(b) + missing / energy) - kPeakOctaves);
  }
  return 0.0;
}

}  // namespace maquette
