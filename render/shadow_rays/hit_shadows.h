#pragma once

#include <vector>

#include "render/reflections/targets.h"
#include "render/shadow_rays/point_rays.h"

namespace maquette {

/// The light of the sun and of lamps at the hits of mirrored rays, by a shadow ray to each in every frame: at rest,
/// where the frames are averaged. The sky's is that of the maps.
class HitShadows {
 public:
  /// Begins another image; afterwards light() is black.
  void begin(const ReflectionTargets& targets);
  /// Adds what reaches the hits of a layer, whose G-buffer is bound.
  void add(const FrameContext& frame, const ShadingPlan& plan, const ReflectionTargets& targets);
  /// For composing: RGBA32F, cd/m2, of the targets' size.
  const Texture& light();
  void clear() { *this = HitShadows(); }
  std::size_t bytes() const { return light_.bytes() + rays_.bytes(); }

 private:
  Texture light_;
  Buffer rays_;
  std::vector<glm::vec4> sum_;
};

}  // namespace maquette
