#pragma once

#include <atomic>
#include <glm/glm.hpp>
#include <memory>
#include <optional>
#include <vector>

#include "render/indirect/indirect_links.h"
#include "render/visibility/visibility_bake.h"
#include "scenes/environment.h"

namespace maquette {

/// The light for which a bake is computed.
struct IndirectSky {
  std::shared_ptr<const Environment> environment;
  float rotation_rad = 0.0f;
  float scale = 1.0f;  ///< cd/m2 per stored unit
  bool operator==(const IndirectSky&) const = default;
};

/// The sky in the cells of the visibility map. Each texel's light is shared by the four cells around it with the
/// weights by which a lookup of the map dithers between them, so that direct light is the same sum here and in the
/// picture.
struct SkyCells {
  std::vector<glm::vec3> irradiance;  ///< of each cell on a surface that faces it: radiance times solid angle
  std::vector<glm::vec3> direction;   ///< mean, weighted by light; shorter than 1 where the cell's light is spread
};
SkyCells splat_sky(const IndirectSky& sky);

/// Indirect light, packed for the GPU by shaders/shared/indirect.glsl.
struct IndirectBake {
  std::vector<glm::uvec4> vertices;  ///< [side][vertex]
  int sides = 1;
  int bias = 0;  ///< of the shared exponent
};

/// Incident indirect radiance of a point: mean + gradient . direction, a cosine-weighted least squares fit over the
/// directions of its side. The gradient has no component along the normal, which is ill-determined (18 times the noise
/// of the mean).
struct IndirectRadiance {
  glm::vec3 mean{0.0f};
  glm::mat3 gradient{0.0f};  ///< columns: R, G, B; each a vector in the tangent plane, world
};

/// How many bounces are computed. `none`: only traces the rays; `step`: one more bounce, continuing from the solution
/// of another sky, so that each bounce is one sky late; `all`: from zero, until a bounce adds less than 0.1 %.
enum class IndirectBounces { none, step, all };

/// The solution for one sky, from which the next one with the same links can continue.
struct IndirectSolution {
  std::vector<IndirectRadiance> radiance;  ///< [side][point], smoothed
  std::vector<glm::vec3> bounced;          ///< [side][point] indirect irradiance
};

/// Irradiance of the sky at every point, [side][point]: from the visibility maps alone, or with what shadow rays find
/// them to err by (render/indirect/sky_rays.h), smoothed.
enum class SkyLight { maps, rays };
std::vector<glm::vec3> sky_irradiance(const IndirectLinks& links, const VisibilityBake& bits, const IndirectSky& sky,
                                      SkyLight by, const std::atomic<bool>& cancel);

/// Solves for one sky, whose light is found by rays for all bounces; `bits` are those of the visibility bake. `before`:
/// the solution that `step` continues from, otherwise ignored; without one it takes all bounces of what the maps show.
/// Null once `cancel` is set. A step costs a fifth of all bounces.
std::optional<IndirectSolution> solve_indirect(const IndirectLinks& links, const VisibilityBake& bits,
                                               const IndirectSky& sky, IndirectBounces bounces,
                                               const IndirectSolution* before, const std::atomic<bool>& cancel);
IndirectBake pack_indirect(const IndirectLinks& links, const std::vector<IndirectRadiance>& radiance);

}  // namespace maquette
