#include "render/environment/bandwidth.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numbers>
#include <set>

#include "render/environment/wavelet_bandwidth.h"
#include "render/math/shared_formulas.h"
#include "scenes/luminance.h"
#include "scenes/parallel.h"

namespace maquette {
namespace {

constexpr std::size_t kMinWidth = 32;
constexpr std::size_t kMaxWidth = 4096;
constexpr std::size_t kMaxCells = 256;
constexpr float kClip = 64.0f;
constexpr float kClipStep = 4.0f;    ///< ratio of neighbouring clip thresholds
constexpr int kMaxClipCount = 10;    ///< a wider range of brightness uses larger steps
constexpr double kTailShare = 0.05;  ///< 95 % of the energy is below the bandwidth
constexpr double kTailContrast = 0.01;
constexpr double kUnaffectedRatio = 8.0;  ///< a lobe of so many times the light's bandwidth removes 3 % of the energy
constexpr double kMaxStretch = 4.0;       ///< limit of the correction by 1 / sin(theta)

/// Luminance, [height][width], width = 2 height = a power of two.
struct Map {
  std::size_t width = 0, height = 0;
  std::vector<float> values;
  const float* row(std::size_t y) const { return &values[y * width]; }
};

/// Luminance resampled to the working size: each texel averages n x n bilinear points; exact box filter for integer
/// factors.
Map working_map(const Environment& environment) {
  Map map;
  const auto wanted = static_cast<std::size_t>(std::max(environment.width, 2 * environment.height));
  map.width = std::clamp(std::bit_ceil(std::max<std::size_t>(1, wanted * 3 / 4)), kMinWidth, kMaxWidth);
  map.height = map.width / 2;
  map.values.resize(map.width * map.height);
  const double step_x = static_cast<double>(environment.width) / static_cast<double>(map.width);
  const double step_y = static_cast<double>(environment.height) / static_cast<double>(map.height);
  const int nx = std::max(1, static_cast<int>(std::ceil(step_x - 1e-9)));
  const int ny = std::max(1, static_cast<int>(std::ceil(step_y - 1e-9)));
  const auto texel = [&](int x, int y) {
    const auto column = static_cast<std::size_t>((x + environment.width) % environment.width);
    const auto row = static_cast<std::size_t>(std::clamp(y, 0, environment.height - 1));
    return luminance(environment.rgb[row * static_cast<std::size_t>(environment.width) + column]);
  };
  const auto bilinear = [&](double x, double y) {
    const int x0 = static_cast<int>(std::floor(x)), y0 = static_cast<int>(std::floor(y));
    const float fx = static_cast<float>(x - x0), fy = static_cast<float>(y - y0);
    if (fx < 1e-4f && fy < 1e-4f) return texel(x0, y0);
    const float top = texel(x0, y0) * (1.0f - fx) + texel(x0 + 1, y0) * fx;
    const float bottom = texel(x0, y0 + 1) * (1.0f - fx) + texel(x0 + 1, y0 + 1) * fx;
    return top * (1.0f - fy) + bottom * fy;
  };
  if (map.values.size() == environment.rgb.size() && nx == 1 && ny == 1) {
    parallel_for(std::size_t{0}, map.height, [&](std::size_t y) {
      const glm::vec3* row = &environment.rgb[y * map.width];
      for (std::size_t x = 0; x < map.width; ++x) map.values[y * map.width + x] = luminance(row[x]);
    });
    return map;
  }
  parallel_for(std::size_t{0}, map.height, [&](std::size_t y) {
    for (std::size_t x = 0; x < map.width; ++x) {
      float sum = 0.0f;
      for (int j = 0; j < ny; ++j)
        for (int i = 0; i < nx; ++i)
          sum += bilinear((static_cast<double>(x) + (i + 0.5) / nx) * step_x - 0.5,
                          (static_cast<double>(y) + (j + 0.5) / ny) * step_y - 0.5);
      map.values[y * map.width + x] = sum / static_cast<float>(nx * ny);
    }
  });
  return map;
}

/// The grid of cells for which bandwidth is computed.
struct Cells {
  std::size_t width = 0, height = 0;
  std::size_t side = 0;  ///< texels a cell side
  int level_count = 0;
  std::vector<float> mean;          ///< [cell], clipped
  std::vector<int> clip;            ///< [cell] index of its threshold
  std::vector<float> thresholds;    ///< by index
  std::vector<float> along_row;     ///< [cell][level] energy density of row coefficients
  std::vector<float> along_column;  ///< [cell][level]
  std::size_t count() const { return width * height; }
};

float neighbourhood_maximum(const Cells& cells, const std::vector<float>& means, std::size_t x, std::size_t y) {
  float largest = 0.0f;
  for (std::size_t ny = y == 0 ? 0 : y - 1; ny <= std::min(cells.height - 1, y + 1); ++ny)
    for (std::size_t dx = 0; dx < 3; ++dx)
      largest = std::max(largest, means[ny * cells.width + (x + dx + cells.width - 1) % cells.width]);
  return largest;
}

Cells make_cells(const Map& map) {
  Cells cells;
  cells.width = std::min(kMaxCells, map.width);
  cells.height = cells.width / 2;
  cells.side = map.width / cells.width;
  cells.level_count = std::countr_zero(map.width) - 1;
  const auto levels = static_cast<std::size_t>(cells.level_count);
  cells.along_row.assign(cells.count() * levels, 0.0f);
  cells.along_column.assign(cells.count() * levels, 0.0f);
  std::vector<float> means(cells.count());
  parallel_for(std::size_t{0}, cells.height, [&](std::size_t cy) {
    for (std::size_t cx = 0; cx < cells.width; ++cx) {
      float sum = 0.0f;
      for (std::size_t y = cy * cells.side; y < (cy + 1) * cells.side; ++y)
        for (std::size_t x = cx * cells.side; x < (cx + 1) * cells.side; ++x) sum += map.row(y)[x];
      means[cy * cells.width + cx] = sum / static_cast<float>(cells.side * cells.side);
    }
  });
  std::vector<float> limits(cells.count());
  float lowest = std::numeric_limits<float>::max(), highest = 0.0f;
  for (std::size_t i = 0; i < cells.count(); ++i) {
    limits[i] = kClip * neighbourhood_maximum(cells, means, i % cells.width, i / cells.width);
    if (limits[i] > 0.0f) lowest = std::min(lowest, limits[i]);
    highest = std::max(highest, limits[i]);
  }
  cells.clip.assign(cells.count(), 0);
  cells.mean = means;
  if (highest <= 0.0f) return cells;
  const double octaves = std::log2(static_cast<double>(highest) / static_cast<double>(lowest));
  const double step = std::max<double>(std::log2(kClipStep), octaves / kMaxClipCount);
  for (int k = 0; k <= static_cast<int>(octaves / step) + 1; ++k)
    cells.thresholds.push_back(static_cast<float>(static_cast<double>(lowest) * std::exp2(step * k)));
  for (std::size_t i = 0; i < cells.count(); ++i)
    if (limits[i] > 0.0f)
      cells.clip[i] =
          static_cast<int>(std::lround(std::log2(static_cast<double>(limits[i]) / static_cast<double>(lowest)) / step));
  return cells;
}

void add_rows(const Map& map, int clip, Cells& cells) {
  const float threshold = cells.thresholds[static_cast<std::size_t>(clip)];
  const auto levels = static_cast<std::size_t>(cells.level_count);
  parallel_for(std::size_t{0}, cells.height, [&](std::size_t cy) {
    const int* clips = &cells.clip[cy * cells.width];
    if (std::find(clips, clips + cells.width, clip) == clips + cells.width) return;
    LevelEnergies pyramid(map.width, cells.level_count);
    for (std::size_t y = cy * cells.side; y < (cy + 1) * cells.side; ++y) {
      std::transform(map.row(y), map.row(y) + map.width, pyramid.signal().begin(),
                     [&](float v) { return std::min(v, threshold); });
      pyramid.transform();
      for (std::size_t cx = 0; cx < cells.width; ++cx) {
        if (clips[cx] != clip) continue;
        float* energies = &cells.along_row[(cy * cells.width + cx) * levels];
        for (std::size_t j = 0; j < levels; ++j)
          energies[j] +=
              pyramid.energy(static_cast<int>(j) + 1, cx * cells.side, cells.side) / static_cast<float>(cells.side);
      }
    }
  });
}

/// Column x down to the south pole and column x + width / 2 back up form one great circle: periodic, without a border.
void add_columns(const Map& map, int clip, Cells& cells) {
  const float threshold = cells.thresholds[static_cast<std::size_t>(clip)];
  const auto levels = static_cast<std::size_t>(cells.level_count);
  const std::size_t half = cells.width / 2;
  parallel_for(std::size_t{0}, half, [&](std::size_t cx) {
    bool used = false;
    for (std::size_t cy = 0; cy < cells.height && !used; ++cy)
      used = cells.clip[cy * cells.width + cx] == clip || cells.clip[cy * cells.width + cx + half] == clip;
    if (!used) return;
    LevelEnergies pyramid(map.width, cells.level_count);
    for (std::size_t x = cx * cells.side; x < (cx + 1) * cells.side; ++x) {
      for (std::size_t y = 0; y < map.height; ++y) {
        pyramid.signal()[y] = std::min(map.row(y)[x], threshold);
        pyramid.signal()[map.width - 1 - y] = std::min(map.row(y)[x + map.width / 2], threshold);
      }
      pyramid.transform();
      for (std::size_t c = 0; c < 2 * cells.height; ++c) {
        const bool back = c >= cells.height;
        const std::size_t cell = (back ? 2 * cells.height - 1 - c : c) * cells.width + (back ? cx + half : cx);
        if (cells.clip[cell] != clip) continue;
        float* energies = &cells.along_column[cell * levels];
        for (std::size_t j = 0; j < levels; ++j)
          energies[j] +=
              pyramid.energy(static_cast<int>(j) + 1, c * cells.side, cells.side) / static_cast<float>(cells.side);
      }
    }
  });
}

/// Spectra along one axis for a row of cells, and the spectra that remain after filtering by each lobe.
class AxisSpectra {
 public:
  /// `negligible`: energy up to which a spectrum counts as 0, one a cell; `cycles_per_rad`: angular frequency of one
  /// cycle per sample.
  AxisSpectra(const LevelSpectrum& spectrum, const float* energies, const std::vector<double>& negligible,
              double cycles_per_rad)
      : spectrum_(spectrum), cycles_per_rad_(cycles_per_rad), bins_(spectrum.bin_count()), seen_(bins_) {
    values_.resize(negligible.size() * bins_);
    spectrum.spectra(energies, negligible.data(), negligible.size(), values_.data());
    for (std::size_t k = 0; k < kSeenBandwidthCount; ++k)
      for (std::size_t b = 0; b < bins_; ++b)
        kept_.push_back(
            static_cast<float>(lobe_energy(cycles_per_rad * LevelSpectrum::bin_frequency(b) / seen_through(k))));
    kept_.insert(kept_.end(), bins_, 1.0f);  // a mirror keeps everything
  }
  /// Computes the spectrum of cell x filtered by lobe k (kSeenBandwidthCount: a mirror); returns its energy.
  double apply_lobe(std::size_t x, std::size_t k) {
    double sum = 0.0;
    for (std::size_t b = 0; b < bins_; ++b)
      sum += static_cast<double>(seen_[b] = values_[x * bins_ + b] * kept_[k * bins_ + b]);
    return sum;
  }
  /// Quantile of the spectrum of the last apply_lobe, cycles/rad.
  double quantile(double tail) const { return cycles_per_rad_ * spectrum_.quantile(seen_.data(), tail); }

 private:
  /// Share of the energy that a Gaussian lobe keeps at `nu` times its nu_rho. nu_rho is the frequency below which 95 %
  /// of the lobe's own energy lies: erf(1.386) = 0.95. It is calibrated with such lobes
  /// (render/materials/bandwidth.cpp).
  static double lobe_energy(double nu) { return std::exp(-1.386 * 1.386 * nu * nu); }

  const LevelSpectrum& spectrum_;
  double cycles_per_rad_;
  std::size_t bins_;
  std::vector<float> values_;  ///< [cell][bin]
  std::vector<float> kept_;    ///< [lobe][bin] share of the energy that the lobe keeps
  std::vector<float> seen_;    ///< [bin] of the last apply_lobe
};

/// Bandwidths of the cells of row cy.
void find_row(const Cells& cells, const LevelSpectrum& spectrum, double samples_per_rad, std::size_t cy,
              EnvironmentTables& tables) {
  const double sin_theta =
      std::sin(std::numbers::pi * (static_cast<double>(cy) + 0.5) / static_cast<double>(cells.height));
  const double stretch = std::min(1.0 / sin_theta, kMaxStretch);
  const std::size_t first = cy * cells.width, level = first * static_cast<std::size_t>(cells.level_count);
  std::vector<double> negligible(cells.width);
  for (std::size_t x = 0; x < cells.width; ++x)
    negligible[x] = std::pow(kTailContrast * static_cast<double>(cells.mean[first + x]), 2.0);
  AxisSpectra row(spectrum, &cells.along_row[level], negligible, stretch * samples_per_rad);
  AxisSpectra column(spectrum, &cells.along_column[level], negligible, samples_per_rad);
  for (std::size_t x = 0; x < cells.width; ++x) {
    const auto seen_by = [&](std::size_t lobe) {
      // The sum along one axis misses what is constant along it; the larger sum is closer to the total.
      const double tail = kTailShare * std::max(row.apply_lobe(x, lobe), column.apply_lobe(x, lobe)) + negligible[x];
      return static_cast<float>(std::hypot(row.quantile(tail), column.quantile(tail)));
    };
    const float own = tables.bandwidth[first + x] = seen_by(kSeenBandwidthCount);
    const float least = std::min(own, shared::kBandwidthLambert);
    float* seen = &tables.seen_bandwidth[(first + x) * kSeenBandwidthCount];
    float narrower = own;
    for (std::size_t k = kSeenBandwidthCount; k-- > 0; seen[k] = narrower)
      if (narrower > least && seen_through(k) < kUnaffectedRatio * own)
        narrower = std::clamp(seen_by(k), least, narrower);
  }
}

}  // namespace

void compute_bandwidth(const Environment& environment, EnvironmentTables& tables) {
  const Map map = working_map(environment);
  Cells cells = make_cells(map);
  tables.bandwidth_width = static_cast<int>(cells.width);
  tables.bandwidth_height = static_cast<int>(cells.height);
  tables.bandwidth.assign(cells.count(), 0.0f);
  tables.seen_bandwidth.assign(cells.count() * kSeenBandwidthCount, 0.0f);
  if (cells.thresholds.empty()) return;
  const std::set<int> used(cells.clip.begin(), cells.clip.end());
  for (const int clip : used) {
    add_rows(map, clip, cells);
    add_columns(map, clip, cells);
  }
  const LevelSpectrum spectrum(cells.level_count);
  parallel_for(std::size_t{0}, cells.height, [&](std::size_t cy) {
    find_row(cells, spectrum, static_cast<double>(map.width) / (2.0 * std::numbers::pi), cy, tables);
  });
}

}  // namespace maquette
