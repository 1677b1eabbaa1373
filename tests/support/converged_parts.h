#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/gl/objects.h"
#include "render/renderer.h"

/// The parts of a converged picture: a few very bright texels (a sun, lamps) by quadrature, everything else by samples,
/// most of them where they are needed.
namespace maquette::test {

/// The square between four texel centres, and the light that is taken out of it: bilinear between the corners.
struct BrightCell {
  glm::vec4 corner;    ///< xy: the upper left texel's column and row, of the map
  glm::vec4 light[4];  ///< rgb, stored units: upper left, upper right, lower left, lower right
};

/// The environment in two summands: one to be rendered, one to be integrated in full, as it is and not as tables pack
/// it.
struct SplitEnvironment {
  std::shared_ptr<const Environment> rest;  ///< without its brightest texels
  std::vector<BrightCell> bright;           ///< what was taken away
};
/// Takes away the texels above 50 times the mean, at most 256; without such `rest` is all and `bright` is empty.
SplitEnvironment split_environment(const Environment& environment);

/// How finely cells are cut: into points_a_side^2 pieces, finer where that is more than `spacing` of what a cell is
/// away from the mirror direction.
struct CellGrid {
  int points_a_side = 2;
  float spacing = 0.1f;
};
/// Grids of two halves whose difference tells the error of either, at most some 1,600 points far from the lobe.
CellGrid coarse_grid(const SplitEnvironment& split);
CellGrid fine_grid(const SplitEnvironment& split);

/// Reflected light of `cells` at every point of the last frame's G-buffer, by the product's own point and BRDF
/// formulas without any random choice. RGB in cd/m2, alpha as the view's.
Image shade_cells(Renderer& renderer, const std::vector<BrightCell>& cells, const CellGrid& grid, bool all_measured);

/// The estimator of mode uniform at single pixels, with measured materials alone, no lamps, no visibility.
class PixelSampler {
 public:
  PixelSampler();
  /// The mean of `samples` at each of `pixels` (x | y << 16), cd/m2. The G-buffer, the seed and the light samples are
  /// those of the last frame that was drawn.
  std::vector<glm::vec3> draw(const std::vector<std::uint32_t>& pixels, int samples) const;

 private:
  GlName<ProgramTraits> program_;
};

/// Runs of the same length at every pixel of one half of a picture, and how many a pixel had.
class SampledHalf {
 public:
  SampledHalf() = default;
  SampledHalf(int width, int height) : mean_(width, height, 4), spread_(mean_.data.size() / 4, 0.0), runs_(spread_) {}
  void add(const Image& run);
  void add(const std::vector<std::uint32_t>& pixels, const std::vector<glm::vec3>& run);
  const Image& mean() const { return mean_; }
  /// The `count` pixels where one more run of this half is worth most, by the variance that whole runs of `other` saw:
  /// a half whose counts depended on its own values would be biased.
  std::vector<std::uint32_t> neediest(const SampledHalf& other, std::size_t count) const;

 private:
  /// Returns what it adds to the sum of squared deviations.
  double add(std::size_t pixel, const glm::vec3& value);
  /// Variance of a run, of the pixel and its neighbours together.
  double variance(int x, int y) const;
  Image mean_;
  double whole_runs_ = 0.0;
  std::vector<double> spread_, runs_;  ///< squared deviations of whole runs, summed over RGB; numbers of runs
};

/// The scene without panes and blended surfaces.
std::shared_ptr<const Scene> without_panes(const Scene& scene);

}  // namespace maquette::test
