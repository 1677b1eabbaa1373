#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "render/materials/brdf_tables.h"
#include "scenes/image.h"

namespace maquette {

/// Reflected under a constant sky: diffuse + f0 A(n.v, roughness) + f90 B(n.v, roughness).
struct SplitsumFit {
  glm::vec3 diffuse{0.0f};
  float alpha = 1.0f;
  glm::vec3 f0{0.0f}, f90{0.0f};
};

/// The shape of a GGX fit with the energy of the table: F0 and F90 by least squares of the relative error over
/// `albedo` ([64] as BrdfTables::albedo), both at least 0. `table` is reflectance_table. A fit of shape in cube-root
/// space alone gives a glossy black plastic four times its light.
SplitsumFit fit_energy(const GgxFit& shape, const std::vector<glm::vec3>& albedo, const Image& table);

}  // namespace maquette
