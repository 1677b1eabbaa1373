#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "render/shadow_rays/point_rays.h"

namespace maquette {

/// A point of a picture, as far as the filter looks at it.
struct SkyPoint {
  glm::vec3 position{0.0f};
  float width_m = 0.0f;    ///< of a pixel there; 0: no point
  glm::vec3 normal{0.0f};  ///< of its triangle
  glm::vec3 base{1.0f};    ///< base colour, which the filter leaves sharp
};
SkyPoint sky_point(const FrameConstants& constants, const PointRays& rays, const SurfacePlace& place);

/// Smooths light of the sky that one ray a frame and point has brought, over as many neighbours on the same surface as
/// it has noise.
class SkyFilter {
 public:
  /// `light`: [row][column] over the base colour, `frames`: in its mean. The result stays until the next call.
  const std::vector<glm::vec4>& run(const std::vector<SkyPoint>& points, const std::vector<glm::vec4>& light,
                                    const glm::ivec2& size, int frames);

 private:
  std::vector<glm::vec4> smooth_, spare_;
};

}  // namespace maquette
