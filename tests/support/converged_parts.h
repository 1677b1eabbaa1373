#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "render/gl/objects.h"
#include "render/renderer.h"

/// A converged picture in two parts: a few very bright texels (a sun, lamps) by quadrature, and everything else by
/// samples, most of them where the picture is noisy.
namespace maquette::test {

/// The square between four texel centres, and the radiance that is removed from it: bilinear between the corners.
struct BrightCell {
  glm::vec4 corner{};    ///< xy: the upper left texel's column and row, of the map
  glm::vec4 light[4]{};  ///< rgb, stored units: upper left, upper right, lower left, lower right
};

/// The environment as a sum: one part to be rendered, one to be integrated exactly, from the original texels rather
/// than the packed tables.
struct SplitEnvironment {
  std::shared_ptr<const Environment> rest;
  std::vector<BrightCell> bright;  ///< what was removed
};
/// Removes the texels above 50 times the mean, at most 256. If there are none, `rest` is the whole environment and
/// `bright` is empty.
SplitEnvironment split_environment(const Environment& environment);

/// Resolution of the cells: points_a_side^2 pieces, and more near the mirror direction, where a piece must not exceed
/// `spacing` times the cell's distance from it.
struct CellGrid {
  int points_a_side = 2;
  float spacing = 0.1f;
};
/// Grids for two halves whose difference gives the error of either; at most some 1,600 points far from the lobe.
CellGrid coarse_grid(const SplitEnvironment& split);
CellGrid fine_grid(const SplitEnvironment& split);

/// Light of `cells` reflected at every point of the last frame's G-buffer, by the product's own point and BRDF
/// formulas, without random choices. RGB in cd/m2, alpha as in the view.
Image shade_cells(Renderer& renderer, const std::vector<BrightCell>& cells, const CellGrid& grid, bool all_measured);

/// The estimator of mode uniform at single pixels, for measured materials only, without lamps and visibility.
class PixelSampler {
 public:
  PixelSampler();
  /// Mean of `samples` samples at each of `pixels` (x
  ///
  /// y << 16), cd/m2. Uses the G-buffer, the seed and the light samples of the last frame.
  std::vector<glm::vec3> draw(const std::vector<std::uint32_t>& pixels, int samples) const;

 private:
  GlName<ProgramTraits> program_;
};

/// Averages runs of equal length at every pixel of one half of a picture, and counts the runs of each pixel.
class SampledHalf {
 public:
  SampledHalf() = default;
  SampledHalf(int width, int height) : mean_(width, height, 4), spread_(mean_.data.size() / 4, 0.0), runs_(spread_) {}
  void add(const Image& run);
  void add(const std::vector<std::uint32_t>& pixels, const std::vector<glm::vec3>& run);
  const Image& mean() const { return mean_; }
  /// The `count` pixels where one more run of this half reduces the error most, by the variance of the whole runs of
  /// `other`: counts that depended on this half's own values would make it biased.
  std::vector<std::uint32_t> neediest(const SampledHalf& other, std::size_t count) const;

 private:
  /// Returns the increase of the sum of squared deviations.
  double add(std::size_t pixel, const glm::vec3& value);
  /// Variance of one run, from the pixel and its neighbours.
  double variance(int x, int y) const;
  Image mean_;
  double whole_runs_ = 0.0;
  std::vector<double> spread_, runs_;  ///< squared deviations of whole runs, summed over RGB; numbers of runs
};

/// The scene without panes and blended surfaces.
std::shared_ptr<const Scene> without_panes(const Scene& scene);

}  // namespace maquette::test
