#pragma once

#include <array>
#include <span>
#include <vector>

#include "render/materials/brdf_tables.h"
#include "scenes/brdf.h"

namespace maquette {

/// Local spectral energy of signals over [0, pi/2] in octave bands, by the Daubechies-4 detail filter.
///
/// At every dyadic cell size d the signal's cell averages are filtered with the four D4 detail taps, without
/// decimation. The squared coefficients within two cells of a position (triangular weights), times d, are the energy
/// there of the band [1/(4 d), 1/(2 d)] cycles/rad: what the decimated transform's coefficient over that position
/// contains. The average over the coarsest cell (pi/4) is the energy below all bands. Both ends are mirrored. Cells of
/// level l cover [0, pi/2 / 2^l] only: fine cells are needed, and known, only near 0, where the square-root spaced bins
/// of MERL are narrow. This handles that spacing without 30,000 samples a signal. Source: Daubechies 1992, Ten Lectures
/// on Wavelets, Table 6.1 (N = 2).
class LocalSpectrum {
 public:
  /// `fine_levels`: 0 resolves cells of pi/256; each further level halves the cell size next to 0.
  explicit LocalSpectrum(int fine_levels);

  /// Positions at which add() needs the signal: angle_rad of each cell, in the order of its argument.
  const std::vector<float>& sample_angles() const { return angles_; }
  /// Adds the band energies of one signal; `samples` at sample_angles(). Energies of several signals accumulate.
  void add(std::span<const float> samples);
  void clear();
  /// Frequency (cycles/rad of the signal's own angle) below which 95 % of the energy at `angle_rad` lies; at least 0.3.
  double frequency_95(double angle_rad) const;

 private:
  struct Level {
    int cells = 0;         ///< of width `width_rad` from 0
    int first_sample = 0;  ///< earlier cells are averages of the next finer level
    int sample_offset = 0;
    double width_rad = 0.0;
    bool whole = true;          ///< covers [0, pi/2]
    std::vector<double> power;  ///< accumulated, per cell
  };
  double energy_at(const Level& level, double angle_rad) const;

  std::vector<Level> levels_;  ///< finest first
  std::vector<double> residual_;
  std::vector<float> angles_;
  std::vector<float> current_, finer_;
};

/// BrdfTables::bandwidth. Along theta_h and along theta_d, with energies summed over R, G, B and six phi_d. The larger
/// of the two, halved because moving one direction by one radian moves the half vector and theta_d by half a radian.
std::vector<float> compute_bandwidth(const BrdfTable& brdf);

}  // namespace maquette
