#include "tests/support/local_bandwidth.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <glm/glm.hpp>
#include <map>
#include <numbers>
#include <numeric>

#include "scenes/luminance.h"

namespace maquette::test {
namespace {

/// Energy over
///
/// frequency
///
/// of windowed lines, at frequencies k / (4 * side): oversampled 4 times, so that the wanted share of the energy falls
/// between close points. Computed from the lines' correlations by a cosine transform (Wiener and Khinchin), because the
/// correlations of all lines can be summed first.
class LineSpectrum {
 public:
  explicit LineSpectrum(int side) : side_(side), bins_(2 * side + 1) {
    cosines_.resize(static_cast<std::size_t>(4 * side));
    for (int i = 0; i < 4 * side; ++i)
      cosines_[static_cast<std::size_t>(i)] = std::cos(2.0 * std::numbers::pi * i / (4.0 * side));
  }
  /// Adds to the correlation of a window's lines, [side].
  void add(const double* a, const double* b, int step, std::vector<double>* correlation) const {
    std::vector<double> la(static_cast<std::size_t>(side_)), lb(la);
    for (int i = 0; i < side_; ++i) {
      la[static_cast<std::size_t>(i)] = a[i * step];
      lb[static_cast<std::size_t>(i)] = b[i * step];
    }
    double* sums = correlation->data();
    for (std::size_t i = 0; i < la.size(); ++i) {
      sums[0] -= la[i] * lb[i];  // counted once, the others from both sides
      for (std::size_t lag = 0; i + lag < la.size(); ++lag) sums[lag] += la[i] * lb[i + lag] + lb[i] * la[i + lag];
    }
  }
  /// The real cross spectrum of a correlation, [bins].
  std::vector<double> energies(const std::vector<double>& correlation) const {
    std::vector<double> energy(static_cast<std::size_t>(bins_), 0.0);
    for (int k = 0; k < bins_; ++k) {
      double sum = 0.0;
      for (int lag = 0; lag < side_; ++lag)
        sum += correlation[static_cast<std::size_t>(lag)] * cosines_[static_cast<std::size_t>(k * lag % (4 * side_))];
      energy[static_cast<std::size_t>(k)] = sum * (k == 0 || k == bins_ - 1 ? 0.5 : 1.0);
    }
    return energy;
  }
  /// Frequency below which `share` of a correlation's energy lies, cycles a sample.
  double bandwidth(const std::vector<double>& correlation, double share) const {
    const std::vector<double> energy = energies(correlation);
    const double goal = share * std::accumulate(energy.begin(), energy.end(), 0.0);
    double sum = 0.0;
    for (std::size_t k = 0; k < energy.size(); ++k) {
      if (sum + energy[k] >= goal) {
        const double inside = energy[k] > 0.0 ? (goal - sum) / energy[k] : 0.0;
        return std::max(0.0, (static_cast<double>(k) - 0.5 + inside) / (4.0 * side_));
      }
      sum += energy[k];
    }
    return 0.5;
  }

 private:
  int side_, bins_;
  std::vector<double> cosines_;
};

std::vector<double> hann(int side) {
  std::vector<double> w(static_cast<std::size_t>(side));
  for (int i = 0; i < side; ++i)
    w[static_cast<std::size_t>(i)] = 0.5 - 0.5 * std::cos(2.0 * std::numbers::pi * (i + 0.5) / side);
  return w;
}

/// Bandwidth of a line without the window's own: what a wave at a quarter of the sampling rate reads above its
/// frequency, or what a constant reads.
class WindowUndoer {
 public:
  WindowUndoer(const LineSpectrum& spectrum, const std::vector<double>& w, const LocalBandwidthOptions& options)
      : undo_(options.undo_window) {
    if (undo_ == UndoWindow::none) return;
    const double frequency = undo_ == UndoWindow::wave ? 0.25 : 0.0;
    std::vector<double> correlation(w.size(), 0.0), line(w.size());
    for (const double phase : {0.0, 0.5 * std::numbers::pi}) {
      for (std::size_t i = 0; i < w.size(); ++i)
        line[i] = w[i] * std::cos(2.0 * std::numbers::pi * frequency * static_cast<double>(i) + phase);
      spectrum.add(line.data(), line.data(), 1, &correlation);
    }
    own_ = spectrum.bandwidth(correlation, options.energy) - frequency;
  }
  double operator()(double read) const {
    return undo_ == UndoWindow::quadrature ? std::sqrt(std::max(read * read - own_ * own_, 0.0))
                                           : std::max(read - own_, 0.0);
  }

 private:
  UndoWindow undo_;
  double own_ = 0.0;
};

/// Number of excluded pixels in any rectangle, by a summed-area table.
class ExcludedCount {
 public:
  ExcludedCount(const std::vector<bool>& usable, int width, int height)
      : width_(width + 1), sums_(static_cast<std::size_t>((width + 1) * (height + 1)), 0) {
    for (int y = 0; y < height; ++y)
      for (int x = 0; x < width; ++x)
        sums_[at(x + 1, y + 1)] = sums_[at(x, y + 1)] + sums_[at(x + 1, y)] - sums_[at(x, y)] +
                                  (usable[static_cast<std::size_t>(y * width + x)] ? 0 : 1);
  }
  int operator()(int x, int y, int side) const {
    return sums_[at(x + side, y + side)] - sums_[at(x, y + side)] - sums_[at(x + side, y)] + sums_[at(x, y)];
  }

 private:
  std::size_t at(int x, int y) const { return static_cast<std::size_t>(y * width_ + x); }
  int width_;
  std::vector<int> sums_;
};

/// The window's luminance times the Hann weights, [side][side].
std::vector<double> windowed(const Image& picture, int x0, int y0, const std::vector<double>& w,
                             const LocalBandwidthOptions& options) {
  const int n = options.window;
  std::vector<double> values(static_cast<std::size_t>(n * n));
  double mean = 0.0, weight = 0.0;
  for (int y = 0; y < n; ++y) {
    for (int x = 0; x < n; ++x) {
      double v = luminance(picture, x0 + x, y0 + y);
      if (options.square_root) v = std::sqrt(std::max(v, 0.0));
      values[static_cast<std::size_t>(y * n + x)] = v;
      const double window = w[static_cast<std::size_t>(x)] * w[static_cast<std::size_t>(y)];
      mean += window * v;
      weight += window;
    }
  }
  mean = options.remove_mean ? mean / weight : 0.0;
  for (int y = 0; y < n; ++y)
    for (int x = 0; x < n; ++x) {
      double& v = values[static_cast<std::size_t>(y * n + x)];
      v = (v - mean) * w[static_cast<std::size_t>(x)] * w[static_cast<std::size_t>(y)];
    }
  return values;
}

}  // namespace

double measured_floor(const LocalBandwidthOptions& options) {
  const int n = options.window;
  const LineSpectrum spectrum(n);
  const std::vector<double> w = hann(n);
  const WindowUndoer undo(spectrum, w, options);
  const double step = 0.05 / n;
  const double longest = options.undo_window == UndoWindow::wave ? 3.0 / n : 0.5 / n;
  double floor = 0.0;
  for (double frequency = step; frequency < longest; frequency += step) {
    for (double phase = 0.0; phase < std::numbers::pi; phase += std::numbers::pi / 16.0) {
      Image wave(n, n, 4, 1.0f);
      for (int y = 0; y < n; ++y)
        for (int x = 0; x < n; ++x)
          for (int c = 0; c < 3; ++c)
            wave.at(x, y, c) =
                static_cast<float>(2.0 + std::cos(2.0 * std::numbers::pi * frequency * (x - 0.5 * (n - 1)) + phase));
      const std::vector<double> line = windowed(wave, 0, 0, w, options);
      std::vector<double> correlation(w.size(), 0.0);
      const auto middle = static_cast<std::size_t>(n / 2 * n);
      spectrum.add(&line[middle], &line[middle], 1, &correlation);
      const double read = undo(spectrum.bandwidth(correlation, options.energy));
      if (options.undo_window != UndoWindow::wave || read > 1.02 * frequency) floor = std::max(floor, read);
    }
  }
  return floor;
}

std::vector<WindowBandwidth> measure_local_bandwidth(const Image& a, const Image& b, const std::vector<bool>& usable,
                                                     const LocalBandwidthOptions& options) {
  const int n = options.window;
  assert(usable.size() == static_cast<std::size_t>(a.width * a.height) && b.width == a.width && b.height == a.height);
  const ExcludedCount excluded(usable, a.width, a.height);
  const LineSpectrum spectrum(n);
  const std::vector<double> w = hann(n);
  const WindowUndoer undo(spectrum, w, options);
  std::vector<WindowBandwidth> result;
  for (int y0 = 0; y0 + n <= a.height; y0 += options.stride) {
    for (int x0 = 0; x0 + n <= a.width; x0 += options.stride) {
      if (excluded(x0, y0, n) > 0) continue;
      const std::vector<double> va = windowed(a, x0, y0, w, options), vb = windowed(b, x0, y0, w, options);
      std::vector<double> along_x(w.size(), 0.0), along_y = along_x;
      for (int i = 0; i < n; ++i) {
        const auto row = static_cast<std::size_t>(i * n), column = static_cast<std::size_t>(i);
        spectrum.add(&va[row], &vb[row], 1, &along_x);
        spectrum.add(&va[column], &vb[column], n, &along_y);
      }
      const auto bandwidth = [&](const std::vector<double>& correlation) {
        return undo(spectrum.bandwidth(correlation, options.energy));
      };
      WindowBandwidth r{x0 + n / 2, y0 + n / 2, bandwidth(along_x), bandwidth(along_y), 0.0};
      double shared = 0.0, difference = 0.0;
      for (std::size_t i = 0; i < va.size(); ++i) {
        shared += va[i] * vb[i];
        difference += 0.25 * (va[i] - vb[i]) * (va[i] - vb[i]);
      }
      r.noise = difference > 0.0 ? difference / std::max(shared, 1e-300) : 0.0;
      result.push_back(r);
    }
  }
  return result;
}

double pooled_prediction(const Image& prediction, const Image& picture, const WindowBandwidth& w, int window,
                         Pooling pooling) {
  if (pooling == Pooling::centre) return prediction.at(w.x, w.y);
  const std::vector<double> line = hann(window);
  const int x0 = w.x - window / 2, y0 = w.y - window / 2;
  LocalBandwidthOptions options;
  options.window = window;
  options.remove_mean = pooling == Pooling::variation;
  const std::vector<double> values = windowed(picture, x0, y0, line, options);
  double sum = 0.0, weight = 0.0, largest = 0.0;
  for (int y = 0; y < window; ++y) {
    for (int x = 0; x < window; ++x) {
      const double value = values[static_cast<std::size_t>(y * window + x)];
      const double hann2 = line[static_cast<std::size_t>(x)] * line[static_cast<std::size_t>(y)];
      const double g = pooling == Pooling::mean ? hann2 : value * value;
      const double predicted = static_cast<double>(prediction.at(x0 + x, y0 + y));
      sum += g * predicted;
      weight += g;
      if (hann2 > 0.25) largest = std::max(largest, predicted);
    }
  }
  return pooling == Pooling::largest ? largest : sum / std::max(weight, 1e-30);
}

namespace {

/// measured_floor of each scale; computed once, because it takes a second.
const std::array<double, kWindowScales.size()>& scale_floors() {
  static const auto floors = [] {
    std::array<double, kWindowScales.size()> f{};
    LocalBandwidthOptions options;
    for (std::size_t k = 0; k < f.size(); ++k) {
      options.window = kWindowScales[k];
      f[k] = measured_floor(options);
    }
    return f;
  }();
  return floors;
}

}  // namespace

std::vector<ScaledBandwidth> measure_scaled_bandwidth(const Image& a, const Image& b, const std::vector<bool>& usable,
                                                      WindowFilter filter, int stride) {
  assert(8 % stride == 0);  // the middles of all windows lie on one grid
  struct Location {
    ScaledBandwidth read;
    bool told = false, off_longest = false;
  };
  std::map<std::pair<int, int>, Location> found;
  for (std::size_t k = 0; k < kWindowScales.size(); ++k) {
    LocalBandwidthOptions options;
    options.window = kWindowScales[k];
    options.stride = stride;
    const bool longest = k + 1 == kWindowScales.size();
    for (const WindowBandwidth& w : measure_local_bandwidth(a, b, usable, options)) {
      Location& location = found[{w.y, w.x}];
      location.off_longest = longest;
      if (location.told || w.noise > kMostNoise) continue;
      location.told = longest || std::max(w.nu_x, w.nu_y) > scale_floors()[k];
      location.read = {w, kWindowScales[k]};
    }
  }
  std::vector<ScaledBandwidth> result;
  for (const auto& [at, location] : found)
    if (location.told && (location.off_longest || filter == WindowFilter::off_own)) result.push_back(location.read);
  return result;
}

std::vector<bool> smooth_surface_pixels(const Image& depth, const Image& normal, const Image& material) {
  const int w = depth.width, h = depth.height;
  std::vector<bool> smooth(static_cast<std::size_t>(w * h), false);
  const auto n = [&](int x, int y) { return glm::vec3(normal.at(x, y, 0), normal.at(x, y, 1), normal.at(x, y, 2)); };
  for (int y = 1; y + 1 < h; ++y) {
    for (int x = 1; x + 1 < w; ++x) {
      if (depth.at(x, y, 3) < 1.0f) continue;
      bool good = true;
      for (int axis = 0; axis < 2 && good; ++axis) {
        const int dx = 1 - axis, dy = axis;
        const float d = depth.at(x, y), a = depth.at(x - dx, y - dy), b = depth.at(x + dx, y + dy);
        // Reciprocal depth is linear over a plane.
        const float curvature = std::abs(1.0f / std::max(a, 1e-30f) + 1.0f / std::max(b, 1e-30f) - 2.0f / d) * d;
        good = a > 0.0f && b > 0.0f && curvature < 0.01f && material.at(x - dx, y - dy) == material.at(x, y) &&
               material.at(x + dx, y + dy) == material.at(x, y) && glm::dot(n(x - dx, y - dy), n(x, y)) > 0.95f &&
               glm::dot(n(x + dx, y + dy), n(x, y)) > 0.95f;
      }
      smooth[static_cast<std::size_t>(y * w + x)] = good;
    }
  }
  return smooth;
}

double rank_correlation(const std::vector<double>& a, const std::vector<double>& b) {
  assert(a.size() == b.size());
  const std::size_t count = a.size();
  if (count < 3) return 0.0;
  const auto ranks = [count](const std::vector<double>& v) {
    std::vector<std::size_t> order(count);
    std::iota(order.begin(), order.end(), std::size_t{0});
    std::sort(order.begin(), order.end(), [&](std::size_t i, std::size_t j) { return v[i] < v[j]; });
    std::vector<double> rank(count);
    for (std::size_t i = 0; i < count;) {
      std::size_t j = i;
      while (j < count && v[order[j]] == v[order[i]]) ++j;
      for (std::size_t k = i; k < j; ++k) rank[order[k]] = 0.5 * static_cast<double>(i + j - 1);
      i = j;
    }
    return rank;
  };
  const std::vector<double> ra = ranks(a), rb = ranks(b);
  const double middle = 0.5 * static_cast<double>(count - 1);
  double ab = 0.0, aa = 0.0, bb = 0.0;
  for (std::size_t i = 0; i < count; ++i) {
    ab += (ra[i] - middle) * (rb[i] - middle);
    aa += (ra[i] - middle) * (ra[i] - middle);
    bb += (rb[i] - middle) * (rb[i] - middle);
  }
  return aa > 0.0 && bb > 0.0 ? ab / std::sqrt(aa * bb) : 0.0;
}

double percentile(std::vector<double> values, double share) {
  if (values.empty()) return 0.0;
  const auto k = static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size() - 1) + 0.5);
  std::nth_element(values.begin(), values.begin() + k, values.end());
  return values[static_cast<std::size_t>(k)];
}
double median(std::vector<double> values) { return percentile(std::move(values), 0.5); }

}  // namespace maquette::test
