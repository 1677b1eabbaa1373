#include "render/shadow_rays/sky_filter.h"

#include <algorithm>
#include <cmath>

#include "render/frame/constants.h"
#include "render/math/shared_formulas.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

/// Pixels over which the first ray of each point is smoothed; fewer as frames are added.
constexpr double kFilterRadius = 14.0;
constexpr int kBaseColorBias = 34;  ///< of shaders/shared/gbuffer.glsl
/// Base colours are not taken for darker.
constexpr float kLeastBase = 0.04f;

/// How much of a neighbour's light a point takes.
float likeness(const glm::vec3& offset, const glm::vec3& normal, const glm::vec3& other, float width_m) {
  const float facing = std::max(glm::dot(normal, other), 0.0f), facing2 = facing * facing, facing4 = facing2 * facing2;
  const float off = glm::dot(offset, normal) / (3.0f * width_m);
  return facing4 * facing4 * std::exp(-off * off);
}

}  // namespace

SkyPoint sky_point(const FrameConstants& constants, const PointRays& rays, const SurfacePlace& place) {
  const glm::vec3 root = shared::unpack_rgb9e5(rays.base_color, kBaseColorBias);
  return {place.position, pixel_width(constants, glm::length(place.position - glm::vec3(constants.eye))), place.normal,
          glm::max(root * root, glm::vec3(kLeastBase))};
}

const std::vector<glm::vec4>& SkyFilter::run(const std::vector<SkyPoint>& points, const std::vector<glm::vec4>& light,
                                             const glm::ivec2& size, int frames) {
  // A ray's noise is about that of a path: as many are taken together, over neighbours and frames, as make a picture.
  // Falling faster than the noise, the radius leaves grain where it would leave blur; FLIP of cabins is the lower for
  // it.
  const int radius = static_cast<int>(std::lround(kFilterRadius * std::pow(frames, -0.75)));
  if (radius == 0) return light;
  smooth_ = light;
  spare_.resize(smooth_.size());
  for (const bool down : {false, true}) {
    parallel_for(0, size.y, [&](int y) {
      for (int x = 0; x < size.x; ++x) {
        const auto index = [&](int i, int j) {
          return static_cast<std::size_t>(j) * static_cast<std::size_t>(size.x) + static_cast<std::size_t>(i);
        };
        const std::size_t at = index(x, y);
        const SkyPoint& own = points[at];
        spare_[at] = glm::vec4(0.0f);
        if (!(own.width_m > 0.0f)) continue;
        float weights = 0.0f;
        for (int k = -radius; k <= radius; ++k) {
          const int i = down ? x : x + k, j = down ? y + k : y;
          if (i < 0 || j < 0 || i >= size.x || j >= size.y) continue;
          const std::size_t to = index(i, j);
          const SkyPoint& other = points[to];
          if (!(other.width_m > 0.0f)) continue;
          const float t = static_cast<float>(k) / static_cast<float>(radius);
          const float weight =
              std::exp(-2.0f * t * t) * likeness(other.position - own.position, own.normal, other.normal, own.width_m);
          spare_[at] += weight * smooth_[to];
          weights += weight;
        }
        spare_[at] /= std::max(weights, 1e-6f);
      }
    });
    smooth_.swap(spare_);
  }
  return smooth_;
}

}  // namespace maquette
