#pragma once

#include <functional>
#include <optional>
#include <vector>

#include "render/parts/parts.h"
#include "render/shading/layer.h"

namespace maquette {

/// What one layer adds to the picture.
struct ComposedLayer {
  const DrawnLayer& layer;
  /// Binds its indirect light of each bake that the frame lies between (shaders/shading/compose.comp); their count.
  std::function<std::size_t()> bind_indirect;
  const Texture* shadow_light = nullptr;  ///< of render/shadow_rays, where the layer has it
};

/// Panes that are drawn in the same step as the points behind them.
struct RecordedPanes {
  const TileList& covered_tiles;  ///< of surfaces: with a pane before them somewhere
  const TileList& bare_tiles;     ///< and without
  std::function<void(const Program&)> bind;
};

/// What a picture is composed of besides its layers.
struct ComposeScene {
  const FrameContext& frame;
  const std::vector<ComposedLayer>& layers;
  const SkyTiles& sky;
  const RecordedPanes* panes = nullptr;   ///< null: they are drawn afterwards, or there are none
  const Texture* glossy_light = nullptr;  ///< of the first layer
};

/// From the layers' radiance to the picture: emission, indirect light, the sky, the mean over samples and frames.
class Composer {
 public:
  /// Makes the images anew where the size is another one. `several`: layers share the frame.
  void fit(const GridSize& size, bool several);
  /// Decides where surfaces are composed: in the picture itself, or in the grid that it is filtered from. `blend`:
  /// weight of this frame in the mean over frames.
  void begin(const FramePlan& plan, const Texture& radiance, float blend);
  void compose(const ComposeScene& scene);
  /// The mean over a pixel's samples, and with the frames before.
  void filter(ProgramCache* programs);

  /// The image that panes are drawn over.
  const Texture& behind_panes() const { return in_picture_ ? picture_ : *grid_; }
  /// Depth of all layers, m along the viewing axis. `only`: of the one layer that there is.
  const Texture& depth(const Surfaces& only) const { return several_ ? depth_ : only.depth(); }
  const Texture& picture() const { return picture_; }  ///< RGBA32F, cd/m2; alpha 0 where only the sky is seen
  /// The grid that the picture is the mean of, where its points are those of the mean over frames; else null.
  const Texture* points() const { return size_.side > 1 && blend_ >= 1.0f ? grid_ : nullptr; }
  const GridSize& size() const { return size_; }
  std::size_t bytes() const { return picture_.bytes() + radiance_.bytes() + depth_.bytes(); }
  static std::vector<ShaderVariant> shader_variants();

 private:
  void draw_sky(const ComposeScene& scene);
  void compose_layer(const ComposeScene& scene, const ComposedLayer& composed);
  void compose_tiles(const ComposeScene& scene, const ComposedLayer& composed, std::size_t bakes);
  void compose_quads(const ComposeScene& scene, const ComposedLayer& composed, std::size_t bakes);
  const Program& program_of(const ComposeScene& scene, const ComposedLayer& composed, int stage, std::size_t bakes,
                            bool quads, bool panes) const;

  GridSize size_;
  bool several_ = false, in_picture_ = false;
  float blend_ = 1.0f;
  Texture picture_;
  const Texture* grid_ = nullptr;  ///< the first layer's radiance, or that of all
  Texture radiance_, depth_;       ///< of all layers, where there are several
  std::optional<Key> sky_;         ///< what the sky's points show; empty: to be drawn
};

}  // namespace maquette
