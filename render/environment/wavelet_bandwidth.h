#pragma once

#include <cstddef>
#include <vector>

namespace maquette {

/// Daubechies-4 wavelet transform of periodic signals, and the local bandwidth that its energies imply. Levels count
/// from 1, the finest: level j covers about [2^-(j+1), 2^-j] cycles per sample.

/// Daubechies-4 coefficients (low-pass first, then detail) of a periodic signal of length n at the positions 0, step, 2
/// step, ...; the filter's four taps lie `dilation` samples apart (1: the ordinary filter; 2: for a signal sampled
/// twice as densely). n is a multiple of both. Source: Daubechies 1988, "Orthonormal Bases of Compactly Supported
/// Wavelets", N = 2.
void d4_low_pass(const float* signal, std::size_t n, std::size_t dilation, std::size_t step, float* low);
void d4_detail(const float* signal, std::size_t n, std::size_t dilation, std::size_t step, float* detail);

/// Local energies per level of one periodic signal whose length is a power of two.
///
/// The critically sampled transform is not shift-invariant: the squares of a tone's coefficients oscillate slowly along
/// the signal. Therefore the low-pass is sampled twice and the detail four times as densely, for 2.5 times the work.
class LevelEnergies {
 public:
  LevelEnergies(std::size_t n, int level_count);
  std::vector<float>& signal() { return signal_; }  ///< write the samples here, then transform
  void transform();
  /// Mean energy density (per sample) of level j (1: the finest) around the samples [begin, begin + side); the window
  /// is at least as long as two coefficients.
  float energy(int level, std::size_t begin, std::size_t side) const;

 private:
  std::vector<float> signal_, low_, next_;
  std::vector<std::vector<float>> squares_;  ///< [level - 1]
  std::vector<std::size_t> spacing_;         ///< [level - 1] samples between the entries of squares_
};

/// Mean share of the energy of a pure tone of `frequency` (cycles per sample) that each of `level_count` levels
/// receives (index j - 1); the rest is in the low-pass.
std::vector<double> d4_response(double frequency, int level_count);

/// Converts energies per level into the frequency above which the spectrum has an energy of `tail`.
///
/// A wavelet level is an octave with soft edges: a tone appears in two or three of them, and a quantile taken from the
/// levels directly would be up to 1.9 times too high. Therefore the spectrum is first estimated in quarter octaves, by
/// Richardson-Lucy iterations with the filters' known response. A tone still becomes a peak of finite width, whose 95 %
/// point is 1.2 to 1.3 times too high; the result is lowered by a constant fifth of an octave, at the cost of a few per
/// cent of the energy of a flat spectrum. Source: Richardson 1972, "Bayesian-Based Iterative Method of Image
/// Restoration".
class LevelSpectrum {
 public:
  explicit LevelSpectrum(int level_count);
  /// energies: [count][level_count], level 1 first, >= 0; negligible: [count], total energy up to which a spectrum
  /// counts as 0; result: [count][bin_count()], the energy of each quarter octave, highest frequency first. About 1
  /// microsecond each.
  void spectra(const float* energies, const double* negligible, std::size_t count, float* result) const;
  std::size_t bin_count() const { return bin_count_; }
  /// Centre of a bin, cycles per sample.
  static double bin_frequency(std::size_t bin);
  /// Quantile of one spectrum, [bin_count()], cycles per sample; 0 when the total energy is at most the tail.
  double quantile(const float* spectrum, double tail) const;

 private:
  struct Group;  ///< a few spectra side by side: the lanes of every loop
  void estimate(Group& group) const;

  std::size_t level_count_;
  std::size_t bin_count_;
  std::vector<float> response_;  ///< [level][bin]
  std::vector<float> gain_;      ///< [bin]: sum over levels
  /// [level] begin and end of the bins with a significant response
  std::vector<std::size_t> begin_, end_;
};

}  // namespace maquette
