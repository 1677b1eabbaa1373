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

/// The light of which a bake was made.
struct IndirectSky {
  std::shared_ptr<const Environment> environment;
  float rotation_rad = 0.0f;
  float scale = 1.0f;  ///< cd/m2 per stored unit
  bool operator==(const IndirectSky&) const = default;
};

/// The sky in the cells of the visibility map: each texel's light is shared by the four cells around it with the
/// weights by which a lookup of the map dithers between them, so that direct light here and in the picture are the same
/// sum.
struct SkyCells {
  std::vector<glm::vec3> irradiance;  ///< of each cell on a surface that faces it: radiance times solid angle
  std::vector<glm::vec3> direction;   ///< mean, weighted by light; not unit where a cell's light is spread
};
SkyCells splat_sky(const IndirectSky& sky);

/// Light that comes by way of other surfaces, packed for the GPU by shaders/shared/indirect.glsl.
struct IndirectBake {
  std::vector<glm::uvec4> vertices;  ///< [side][vertex]
  int sides = 1;
  int bias = 0;  ///< of the shared exponent
};

/// Radiance that arrives at a point from other surfaces: mean + gradient . direction, cosine-weighted least squares
/// over the directions of its side. The part of the gradient along the normal is left 0: it is ill-determined (18 times
/// the noise of the mean).
struct IndirectRadiance {
  glm::vec3 mean{0.0f};
  glm::mat3 gradient{0.0f};  ///< columns: R, G, B; each a vector in the tangent plane, world
};

/// How far bounces are followed. `none`: rays are traced, and that is all; `step`: one more bounce for what light
/// another sky left, so that each bounce comes a sky later; `all`: from nothing, until a bounce adds less than 0.1 %.
enum class IndirectBounces { none, step, all };

/// What solving for one sky leaves for the next one of the same links.
struct IndirectSolution {
  std::vector<IndirectRadiance> radiance;  ///< [side][point], smoothed
  std::vector<glm::vec3> bounced;          ///< [side][point] irradiance by way of other surfaces
};

/// Light for one sky; `bits` are the visibility bake's. `before`: what `step` goes on from, else ignored; may be null.
/// Null once `cancel` is set. A step costs a fifth of all bounces.
std::optional<IndirectSolution> solve_indirect(const IndirectLinks& links, const VisibilityBake& bits,
                                               const IndirectSky& sky, IndirectBounces bounces,
                                               const IndirectSolution* before, const std::atomic<bool>& cancel);
IndirectBake pack_indirect(const IndirectLinks& links, const std::vector<IndirectRadiance>& radiance);

}  // namespace maquette
