#pragma once

#include <optional>
#include <vector>

#include "render/shading/shading_mode.h"
#include "render/shading/work_lists.h"

namespace maquette {

/// What is predicted of a layer's points: a share of the tiles while the light rotates, those whose measured table was
/// swapped.
struct PredictedPart {
  const TileList& tiles;
  TileShare share = {};
  /// Samples will not draw the sun: it is no part of their variance.
  bool sky_variance = false;
};

/// Local bandwidth and variance of what a layer shows, by quads of 2 x 2 points, and its pyramid
/// (docs/numerics/bandwidth.md).
class Prediction {
 public:
  void fit(const GridSize& size);
  /// The curvature of surfaces along the screen; clears what is predicted from it.
  void find_curvature(const LayerContext& layer);
  /// `lists`: of the mode, in which quads are listed.
  void predict(const LayerContext& layer, const PredictedPart& part, WorkLists* lists);
  void make_pyramid(ProgramCache* programs);
  /// What baked visibility leaves open towards mirror directions, for the passes that mark: of all tiles, or, where
  /// that is known already for surfaces and bake, of `swapped` ones alone.
  void find_sky_visibility(const LayerContext& layer, const TileList* swapped);

  const Texture& axes() const { return axes_; }
  const Texture& pyramid() const { return pyramid_; }
  static std::vector<ShaderVariant> shader_variants();
  std::size_t bytes() const;
  /// Views of curvature and prediction.
  std::optional<PointValue> view(const std::string& name) const;

 private:
  /// Quads make whole blocks of 2 x 2: tiles make the pyramid's second level as well.
  bool whole_blocks() const { return energy_.width() % 2 == 0 && energy_.height() % 2 == 0; }
  void list_quads(const LayerContext& layer, const PredictedPart& part, WorkLists* lists) const;

  GridSize size_;
  Texture energy_;                 ///< RGBA32F, [quad]
  Texture screen_curvature_;       ///< RGBA32UI, [quad] (shaders/shared/screen_curvature.glsl)
  Texture axes_;                   ///< RGBA16F, [quad]: bandwidth along the axes, their correlation, nu_theta
  Texture pyramid_;                ///< RGBA32F, level 0: [quad]
  Texture near_terms_;             ///< RGBA32F, [quad]: bandwidth of visibility and of lights nearby
  Texture sky_visibility_;         ///< R8, [point]
  std::optional<Key> open_of_;     ///< surfaces and bake that `sky_visibility_` was found for
  std::uint32_t open_tables_ = 0;  ///< and revision of the measured tables
};

}  // namespace maquette
