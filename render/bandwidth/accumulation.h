#pragma once

#include <cstdint>
#include <vector>

#include "render/gbuffer/tiles.h"
#include "render/gl/objects.h"
#include "render/shading/shading_mode.h"

namespace maquette {

/// How measured deviations become work items in the next frame.
struct RefineRates {
  float items_per_deviation = 0.0f;
  float least_deviation = 0.0f;  ///< added everywhere, so that nothing the measurement missed starves
  unsigned most_items = 0;       ///< of either list, should the rate have been too bold
  double light_rounds = 0.0;     ///< how often the typical point has used up the list of light samples
};

/// What mode `bandwidth` keeps of each grid point while nothing moves, and what it measures of it: the deviations so
/// far decide who gets how many samples, and the distance of own means from what was interpolated decides where
/// interpolation still serves. Made only for pictures that accumulate.
class Accumulation {
 public:
  /// For pictures of `size` with room for `tile_count` tiles; `levels`: that are interpolated; `textures`: points are
  /// kept without their base factor (shaders/bandwidth/base_factor.glsl).
  Accumulation(const GridSize& size, std::size_t tile_count, int levels, bool textures);
  void clear();
  int levels() const { return levels_; }
  bool textures() const { return spread_format_ == GL_RG32F; }
  /// What the frames so far say about the next one's sample counts. `visible`: points.
  RefineRates measure(const LayerContext& layer, const Texture& pyramid, const Texture& marks, std::size_t visible);
  /// Whether the list of light samples, used up `rounds` times by the typical point, is to be drawn anew: every point
  /// then begins another sequence, at the price of an error that falls more slowly, so that a few points with many
  /// samples see it more than once, unless they are where the samples go.
  bool needs_new_light_samples(double rounds);
  /// Drops what is known of points in these tiles.
  void forget(const TileList& tiles, ProgramCache* programs);
  void bind_for_gathering() const;  ///< images 1 and 2
  void bind_for_marking() const;    ///< unit 72
  void bind_for_filling() const;    ///< units 18, 19 and 56, image 1
  /// Of each grid point the share of what it shows that was interpolated from others.
  std::vector<float> borrowed_shares(const std::vector<std::uint8_t>& marks, int samples_per_item) const;
  static std::vector<ShaderVariant> shader_variants();
  std::size_t bytes() const {
    return mean_.bytes() + spread_.bytes() + deviation_.bytes() + residual_.bytes() + residuals_.bytes() +
           worth_.bytes() + sums_.bytes();
  }

 private:
  /// By layer: the median over the tiles that were measured.
  std::vector<float> typical_kappas() const;

  int levels_ = 0;
  GLenum spread_format_;
  Texture mean_;         ///< RGBA32F: mean of the point's work items, and their number
  Texture spread_;       ///< R32F: sum of squared deviations of the items; RG32F with the mean of LightDraw::tinted
  Texture deviation_;    ///< R32F: measured deviation of one sample
  Texture residual_;     ///< R32F: squared distance of own mean and what was interpolated there; -1 for none
  Texture residuals_;    ///< RGBA32F: its sums [layer][tile] (shaders/bandwidth/measure.comp)
  Texture worth_;        ///< RG32F: what interpolation is worth [layer][tile] (shaders/shared/interpolation.glsl)
  Buffer sums_;          ///< two vec4 a tile, as in the list of tiles
  double rate_ = 0.0;    ///< items per deviation of the frame before; 0 for none
  double rounds_ = 0.0;  ///< of the list of light samples, by the typical point
};

}  // namespace maquette
