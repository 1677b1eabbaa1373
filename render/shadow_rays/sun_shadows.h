#pragma once

#include <cstdint>
#include <vector>

#include "render/frame/context.h"
#include "render/shadow_rays/point_rays.h"

namespace maquette {

struct SunBuffers;

/// Shadows of a compact sun on surfaces that stay where they are while the light turns: rays are traced before light is
/// computed, so that it is computed only in tiles that the sun reaches.
class SunShadows {
 public:
  /// Whether the places of these surfaces are known.
  bool know(const Surfaces& surfaces) const { return of_ == surfaces.revision() && !places_.empty(); }
  /// Forgets all places, for those of `surfaces`.
  void begin(const Surfaces& surfaces, std::size_t points);
  /// A grid point's place.
  void set(std::size_t at, const SurfacePlace& place) { places_[at] = place; }
  /// Traces a ray to the sun from each point that faces it. Returns their number.
  std::size_t trace(const LayerContext& layer, const SunBuffers& sun);
  /// What passes to the point, per channel; 0 where none was traced.
  const glm::vec3& passed(std::size_t at) const { return passed_[at]; }
  /// Tiles with a point that the sun reaches.
  const TileList& lit() const { return lit_; }

 private:
  void list_lit(const Surfaces& surfaces);

  std::uint32_t of_ = 0;
  std::vector<SurfacePlace> places_;  ///< of the grid; normal 0: no surface
  std::vector<glm::vec3> facing_;     ///< shading normals, world
  std::vector<glm::vec3> passed_;
  TileList lit_;
};

}  // namespace maquette
