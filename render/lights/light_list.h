#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "render/geometry.h"

namespace maquette {

/// One sampled light of the GPU list: 64 bytes, std430.
struct LightRecord {
  glm::vec3 position;   ///< m; first vertex of an emissive triangle; unused for directional
  std::uint32_t kind;   ///< 0 directional, 1 point, 2 spot, 3 emissive triangle
  glm::vec3 direction;  ///< unit, where the light shines; triangle: edge 1 (m)
  float range_m;        ///< 0: infinite
  glm::vec3 color;      ///< lux, candela, or emitted radiance (cd/m2)
  float selection_pdf;  ///< probability of choosing this light by power
  glm::vec3 edge2;      ///< triangle: edge 2 (m); spot: (cos inner, cos outer, 0)
  float cdf;            ///< cumulative selection probability, inclusive
};

/// Punctual lights and the triangles of emissive materials. At most `max_triangles` triangles are kept, the strongest
/// first; `dropped_power` is the share of the power left out (0 in ordinary scenes).
struct LightList {
  std::vector<LightRecord> lights;
  double dropped_power = 0.0;
};
LightList build_light_list(const Scene& scene, const FlatGeometry& geometry, int variant, int max_triangles = 4096);

}  // namespace maquette
