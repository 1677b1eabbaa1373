#pragma once

#include <vector>

#include "render/reflections/targets.h"
#include "render/shadow_rays/sky_filter.h"

namespace maquette {

/// The light of the sun and of lamps at the hits of mirrored rays, by a shadow ray to each in every frame: at rest,
/// where the frames are averaged. What the maps err by for the sky comes by a ray too where a mean over frames may be
/// negative in one.
class HitShadows {
 public:
  /// Begins another image; afterwards light() is black.
  void begin(const ReflectionTargets& targets);
  /// What the hits of a layer get, whose G-buffer is bound.
  struct Layer {
    const ShadingPlan& plan;
    const FrameConstants& constants;  ///< of the targets
    int sky_frames = 0;               ///< the mean's, with this one; 0: none of the sky's
  };
  void add(const FrameContext& frame, const Layer& layer, const ReflectionTargets& targets);
  /// For composing: RGBA32F, cd/m2, of the targets' size.
  const Texture& light();
  void clear() { *this = HitShadows(); }
  std::size_t bytes() const { return light_.bytes() + rays_.bytes(); }

 private:
  Texture light_;
  Buffer rays_;
  std::vector<glm::vec4> sum_, sky_;  ///< the sky's over the base colour
  std::vector<SkyPoint> points_;
  SkyFilter filter_;
};

}  // namespace maquette
