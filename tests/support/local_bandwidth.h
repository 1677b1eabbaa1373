#pragma once

#include <array>
#include <vector>

#include "scenes/image.h"

namespace maquette::test {

/// How the spread of the window's own spectrum is taken out of what is read of a spectrum.
enum class UndoWindow {
  none,
  /// nu^2 = read^2 - window^2: right for the second moment of a spectrum, and for wide ones. A wave reads 1.25 (at
  /// three over the window's side) to 1.6 times (at one) its frequency.
  quadrature,
  /// nu = read - what a wave reads above its frequency: nothing that is limited to some bandwidth reads more than that,
  /// a wave its frequency, wide spectra up to one over the window's side less.
  wave,
};

/// How the local bandwidth of a picture is measured: a Hann window, the Fourier energy of the luminance in it.
struct LocalBandwidthOptions {
  int window = 32;           ///< side, pixels
  int stride = 8;            ///< between the corners of windows
  double energy = 0.95;      ///< share of the spectral energy within the bandwidth
  bool remove_mean = true;   ///< the constant (weighted by the window) is no variation
  bool square_root = false;  ///< of the luminance first: the eye's and the tone curve's compression
  UndoWindow undo_window = UndoWindow::wave;
};

struct WindowBandwidth {
  int x = 0, y = 0;   ///< of its middle
  double nu_x = 0.0;  ///< cycles/px: |frequency| along x that holds the share of the energy
  double nu_y = 0.0;
  double noise = 0.0;  ///< energy of the pictures' mean that is noise, over that of the variation
};

/// One per window that holds no excluded pixel; `usable` is row-major, one a pixel. `a` and `b` are the same picture
/// with independent noise (or twice the same one): their cross spectrum has the energy of what they share, so that
/// noise does not pass for bandwidth.
std::vector<WindowBandwidth> measure_local_bandwidth(const Image& a, const Image& b, const std::vector<bool>& usable,
                                                     const LocalBandwidthOptions& options);

/// How the prediction at a window's pixels becomes one number to set beside the measurement.
enum class Pooling {
  centre,
  mean,       ///< weighted by the window
  variation,  ///< by the energy that the spectrum holds: of the window times the light without its mean (Parseval)
  light,  ///< by the energy of the light, its mean included: what is bright and even counts, which no spectrum shows
  largest,
};
double pooled_prediction(const Image& prediction, const Image& picture, const WindowBandwidth& w, int window,
                         Pooling pooling);

/// What the measure can still read, cycles/px: the most that waves read which read more than 2 % above their frequency.
/// Those are waves longer than a window, whose mean was taken out; what is undone in quadrature reads all waves too
/// high, and its floor is the most that waves longer than two windows read.
double measured_floor(const LocalBandwidthOptions& options);

/// Energy of the noise over that of the variation above which a window has no bandwidth that could be measured.
inline constexpr double kMostNoise = 0.2;

/// Sides of the windows of a measure whose resolution follows the frequency, as that of wavelets does.
inline constexpr std::array<int, 4> kWindowScales{16, 32, 64, 128};
/// Below this, the two waves that the longest window is long, a place counts as smooth: shading, which asks for four
/// points a cycle, does not go beyond its coarsest grid either (bandwidth.max_level = 4, 16 pixels).
inline constexpr double kScaledFloor = 2.0 / kWindowScales.back();

/// Which places a measure by scales takes.
enum class Places {
  off_longest,  ///< the longest window holds no excluded pixel, whichever is read
  off_own,      ///< the window that is read holds none: more places, but those that need a longer window are missing
};

struct ScaledBandwidth {
  WindowBandwidth place;
  int window = 0;  ///< side of the window that it is read in
};

/// Reads each place in the shortest window that can tell its bandwidth: above that window's floor and, as noise
/// allows, not drowned. What no window tells reads what the longest one does. `stride` must divide 8.
std::vector<ScaledBandwidth> measure_scaled_bandwidth(const Image& a, const Image& b, const std::vector<bool>& usable,
                                                      Places places, int stride = 8);

/// Pixels that show a surface and lie on no geometric edge: same material as their four neighbours, depth that
/// continues linearly, normals that turn smoothly. The pictures are debug views of one size.
std::vector<bool> smooth_surface_pixels(const Image& depth, const Image& normal, const Image& material);

/// Spearman's rank correlation, ties at their mean rank; 0 for fewer than 3 pairs.
double rank_correlation(const std::vector<double>& a, const std::vector<double>& b);
double median(std::vector<double> values);
double percentile(std::vector<double> values, double share);

}  // namespace maquette::test
