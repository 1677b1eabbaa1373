#pragma once

#include <array>
#include <memory>
#include <optional>
#include <vector>

#include "render/reflections/mirrored_rays.h"

namespace maquette {

/// The layers of blended surfaces that a point may show; more behind them look like the last one.
inline constexpr int kMostBlendedLayers = 4;

/// Whether a part of an item is a surface that lets through what is behind it.
bool is_blended(const SceneState& scene, std::size_t item);

/// What blended surfaces show, before they are drawn over the picture: their layers are peeled off from front to back,
/// and each is shaded as the hits of mirrored rays are, by the modes of its parts, with materials and lights as any
/// opaque surface. Source: Everitt 2001, "Interactive Order-Independent Transparency".
class Blended {
 public:
  /// Nothing of it is drawn: frees all.
  void clear() { *this = Blended(); }
  /// What carries out the pass `blended`. `surfaces`: all that the G-buffer depends on. `averages_points`: of the mode;
  /// the other modes average whole pictures.
  void run(const MirroredScene& scene, const Key& surfaces, bool averages_points);
  /// Binds radiance and depth of the layers for shaders/glass/glass.frag.
  void bind(const Program& program) const;
  std::size_t bytes() const;
  static std::vector<ShaderVariant> shader_variants();

 private:
  void fit(const GridSize& size);
  void fit_layers(int count);
  /// Those that may be seen.
  std::vector<std::size_t> items(const MirroredScene& scene) const;
  /// Draws the nearest of those behind layer `layer - 1`; false when there are none.
  bool peel(const MirroredScene& scene, const std::vector<std::size_t>& items, int layer);
  void shade(const MirroredScene& scene, int layer, float blend);

  MirroredRays rays_;
  std::unique_ptr<ReflectorTechnique> technique_;
  GlName<FramebufferTraits> framebuffer_;
  Texture depth_buffer_;
  std::array<Texture, 2> depth_;  ///< R32F, of this layer and the one before
  Texture radiance_, depths_;     ///< RGBA32F and R32F, [layer]: as many as there have been
  int kept_layers_ = 0;
  int count_ = 0;               ///< layers of this frame
  std::optional<Key> mean_of_;  ///< what `radiance_` is the mean of,
  int frames_ = 0;              ///< over so many frames
};

}  // namespace maquette
