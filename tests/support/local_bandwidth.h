#pragma once

#include <array>
#include <vector>

#include "scenes/image.h"

namespace maquette::test {

/// How the width of the window's own spectrum is removed from a measured bandwidth.
enum class UndoWindow {
  none,
  /// nu^2 = read^2 - window^2: exact for the second moment of a spectrum, and for wide spectra. A wave reads 1.25 times
  /// (at three periods a window) to 1.6 times (at one period) its frequency.
  quadrature,
  /// nu = read - the excess that a wave reads above its frequency. A signal limited to some bandwidth never reads more
  /// than that; a wave reads its frequency; wide spectra read up to one period a window less.
  wave,
};

/// How the local bandwidth of a picture is measured: Fourier energy of the luminance in a Hann window.
struct LocalBandwidthOptions {
  int window = 32;           ///< side, pixels
  int stride = 8;            ///< between the corners of windows
  double energy = 0.95;      ///< share of the spectral energy below the bandwidth
  bool remove_mean = true;   ///< subtract the mean (weighted by the window), which is no variation
  bool square_root = false;  ///< take the square root of the luminance first, as the eye and the tone curve compress it
  UndoWindow undo_window = UndoWindow::wave;
};

struct WindowBandwidth {
  int x = 0, y = 0;   ///< of the window's middle
  double nu_x = 0.0;  ///< cycles/px: |frequency| along x below which the share of the energy lies
  double nu_y = 0.0;
  double noise = 0.0;  ///< noise energy in the mean of both pictures, over the energy of the variation
};

/// One for each window without excluded pixels; `usable` is row-major, one entry a pixel. `a` and `b` are the same
/// picture with independent noise (or the same picture twice): their cross spectrum has the energy of what they have in
/// common, so that noise does not count as bandwidth.
std::vector<WindowBandwidth> measure_local_bandwidth(const Image& a, const Image& b, const std::vector<bool>& usable,
                                                     const LocalBandwidthOptions& options);

/// How the predictions at a window's pixels are combined into one number for comparison with the measurement.
enum class Pooling {
  centre,
  mean,       ///< weighted by the window
  variation,  ///< weighted by the energy in the spectrum: of the window times the light without its mean (Parseval)
  light,      ///< weighted by the energy of the light, mean included: counts bright even areas, which no spectrum shows
  largest,
};
double pooled_prediction(const Image& prediction, const Image& picture, const WindowBandwidth& w, int window,
                         Pooling pooling);

/// Smallest bandwidth that the measure can tell, cycles/px: the most that a wave reads whose reading is more than 2 %
/// above its frequency. Such waves are longer than a window and have lost their mean. With UndoWindow::quadrature all
/// waves read too high, so there the floor is the most that waves longer than two windows read.
double measured_floor(const LocalBandwidthOptions& options);

/// Largest ratio of noise energy to variation energy at which a window's bandwidth can be measured.
inline constexpr double kMostNoise = 0.2;

/// Window sides of the measure at several scales, whose resolution follows the frequency, as that of wavelets does.
inline constexpr std::array<int, 4> kWindowScales{16, 32, 64, 128};
/// Below this (two waves in the longest window) a picture counts as smooth there. Shading, which needs four points a
/// cycle, does not go beyond its coarsest grid either (bandwidth.max_level = 4, 16 pixels).
inline constexpr double kScaledFloor = 2.0 / kWindowScales.back();

/// Which locations the measure at several scales includes.
enum class WindowFilter {
  off_longest,  ///< those whose longest window has no excluded pixel, whichever window is read
  off_own,  ///< those whose window that is read has none: more locations, but not those that would need a longer window
};

struct ScaledBandwidth {
  WindowBandwidth bandwidth;
  int window = 0;  ///< side of the window that was read
};

/// Reads each location in the shortest window that can tell its bandwidth: one whose floor is below it and whose noise
/// is low enough. If none can, the location has the reading of the longest window. `stride` must divide 8.
std::vector<ScaledBandwidth> measure_scaled_bandwidth(const Image& a, const Image& b, const std::vector<bool>& usable,
                                                      WindowFilter filter, int stride = 8);

/// Pixels that show a surface and lie on no geometric edge: their four neighbours have the same material, their depth
/// is linear, and their normals vary smoothly. The pictures are debug views of one size.
std::vector<bool> smooth_surface_pixels(const Image& depth, const Image& normal, const Image& material);

/// Spearman's rank correlation, ties at their mean rank; 0 for fewer than 3 pairs.
double rank_correlation(const std::vector<double>& a, const std::vector<double>& b);
double median(std::vector<double> values);
double percentile(std::vector<double> values, double share);

}  // namespace maquette::test
