#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "render/materials/brdf_tables.h"

namespace maquette {

/// What gives a SG fit the albedo of its table at every view elevation.
struct SgEnergy {
  glm::vec3 diffuse{0.0f};             ///< no more than the table's least albedo
  std::vector<glm::vec3> view_factor;  ///< [64] of all lobes, at the elevations of BrdfTables::albedo
};
SgEnergy fit_energy(const SgFit& shape, const std::vector<glm::vec3>& albedo);

}  // namespace maquette
