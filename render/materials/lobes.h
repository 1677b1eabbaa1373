#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "render/materials/brdf_tables.h"

namespace maquette {

/// What a table makes of light for a view at theta_o, in the frame of view and normal (the view in the xz plane, on the
/// side of +x). A lobe sees of a radiance that is linear in the direction exactly its value in the mean direction,
/// times the albedo.
struct BrdfLobe {
  /// Mean direction to the light, weighted by Y(f) cos(theta_i): (0, 0, 2/3) for a Lambertian table, the mirror
  /// direction for a mirror.
  glm::vec3 direction{0.0f, 0.0f, 2.0f / 3.0f};
  /// The part that mirrors: what f has beyond its median over the hemisphere, cosine-weighted. Its share of
  /// BrdfTables::albedo, its mean direction, and the angle from there within which half of it lies.
  glm::vec3 mirror_albedo{0.0f};
  glm::vec3 mirror_direction{0.0f, 0.0f, 2.0f / 3.0f};
  float mirror_half_angle_rad = 1.5707963f;
};

/// [64], theta_o = i / 63 * pi/2: the rows of BrdfTables::albedo.
std::vector<BrdfLobe> compute_lobes(const BrdfTable& brdf, const BrdfTables& tables);

/// Roughness (glTF's) of the GGX lobe that is as wide as what mirrors at 36 degrees: half of a GGX lobe's light lies
/// within atan(alpha) of half vectors.
float mirror_roughness(const std::vector<BrdfLobe>& lobes);

}  // namespace maquette
