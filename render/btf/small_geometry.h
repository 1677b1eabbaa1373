#pragma once

#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

namespace maquette {

/// A surface seen through a magnifying glass: a height field over one tile that repeats without a seam, with its own
/// reflectance. Lengths in sides of the tile; x along growing u, y up in the images, z away from the base plane z = 0.
/// Each cell reflects diffusely and by one GGX lobe over its mean normal.
struct SmallGeometry {
  int side = 0;                    ///< cells along each side of the tile
  std::vector<float> heights;      ///< [side y][side x], at the cells' corners (x, y) / side
  std::vector<glm::vec3> diffuse;  ///< [side y][side x] albedo of the cells, each component below 1
  std::vector<float> specular;     ///< [side y][side x] reflectance of the lobe at normal incidence; 0: no lobe
  float alpha = 0.3f;              ///< roughness of all lobes
  float height(int x, int y) const { return heights[index(x, y)]; }
  /// Of a cell or corner; wraps.
  std::size_t index(int x, int y) const {
    const auto wrap = [n = side](int i) { return static_cast<std::size_t>(((i % n) + n) % n); };
    return wrap(y) * static_cast<std::size_t>(side) + wrap(x);
  }
};

/// A flat one of one reflectance, to change.
SmallGeometry flat_geometry(int side, const glm::vec3& diffuse, float specular = 0.0f, float alpha = 0.3f);

/// Reflection of the lobe, 1/sr. wi, wo: unit; n: unit; all on the same side of the surface. Reciprocal.
/// Source: Walter et al. 2007 (GGX); masking correlated in height, Heitz 2014, Eq. 99; Fresnel: Schlick 1994.
float ggx_lobe(float specular, float alpha, const glm::vec3& n, const glm::vec3& wi, const glm::vec3& wo);

}  // namespace maquette
