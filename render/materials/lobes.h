#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "render/materials/brdf_tables.h"

namespace maquette {

/// Mean direction to the light, weighted by Y(f) cos(theta_i), for a view at theta_o = i / 63 * pi/2 in the xz plane,
/// +x side; the same rows as BrdfTables::albedo. (0, 0, 2/3) for a Lambertian table, the mirror direction for a mirror.
/// A lobe sees of a radiance that is linear in the direction exactly its value there, times the albedo.
std::vector<glm::vec3> compute_lobe_directions(const BrdfTable& brdf, const BrdfTables& tables);

}  // namespace maquette
