#pragma once

#include <optional>
#include <vector>

#include "render/frame/context.h"
#include "render/frame/key.h"
#include "render/shadow_rays/sky_filter.h"
#include "render/shadow_rays/sun_shadows.h"

namespace maquette {

/// The light of a layer that only rays can shadow at the picture's resolution: of the sun and of the scene's lights,
/// and, while nothing moves, what the visibility maps err by for the rest of the sky. Rays are drawn by the device,
/// traced on the processor, and summed here.
class ShadowPass {
 public:
  /// Computes this frame's light. `averages`: the mean over the frames of the picture, where their pictures are not
  /// averaged.
  void run(const LayerContext& layer, bool averages);
  /// For composing: RGBA32F, cd/m2, of the grid.
  const Texture& light() const { return light_; }
  std::size_t bytes() const { return light_.bytes() + rays_.bytes(); }
  std::size_t ray_count() const { return ray_count_; }

 private:
  /// What the rays of this frame go to, and which points are drawn.
  struct Drawn {
    const TileList& tiles;
    bool lamps = false;
    bool sun_first = false;  ///< the sun's rays are traced
    bool learns = false;     ///< all places, for frames where they are
    int number = 0;          ///< of the rays of a point
  };
  void trace_band(const LayerContext& layer, std::size_t band, const Drawn& drawn);

  Texture light_;
  Buffer rays_;                               ///< of one band of tiles, as shaders/shadow_rays/draw.comp writes them
  std::vector<glm::vec4> sun_, lamps_, sky_;  ///< means over the frames; the sky's over the base colour
  std::vector<glm::vec4> sum_;                ///< what is composed
  std::vector<SkyPoint> points_;
  SkyFilter filter_;
  SunShadows sun_shadows_;
  std::size_t ray_count_ = 0;
  int frames_ = 0, lamp_frames_ = 0, sky_frames_ = 0;
  std::optional<Key> lamps_of_;  ///< they do not turn with the sky
};

}  // namespace maquette
