#pragma once

#include <glm/glm.hpp>
#include <vector>

#include "render/materials/brdf_tables.h"

namespace maquette {

/// Reflection of a table for a view at theta_o, in the frame of view and normal (the view in the xz plane, on the side
/// of +x). For a radiance that is linear in the direction the reflected light is exactly its value in the mean
/// direction, times the albedo.
struct BrdfLobe {
  /// Mean direction to the light, weighted by Y(f) cos(theta_i): (0, 0, 2/3) for a Lambertian table, the mirror
  /// direction for a mirror.
  glm::vec3 direction{0.0f, 0.0f, 2.0f / 3.0f};
  /// The mirroring part: what f has above its median over the hemisphere, cosine-weighted. Its share of
  /// BrdfTables::albedo, its mean direction, and the angle around it that contains half of it.
  glm::vec3 mirror_albedo{0.0f};
  glm::vec3 mirror_direction{0.0f, 0.0f, 2.0f / 3.0f};
  float mirror_half_angle_rad = 1.5707963f;
};

/// [64], theta_o = i / 63 * pi/2: the rows of BrdfTables::albedo.
std::vector<BrdfLobe> compute_lobes(const BrdfTable& brdf, const BrdfTables& tables);

/// Roughness (glTF's) of the GGX lobe that is as wide as the mirroring part at 36 degrees: half of a GGX lobe's light
/// has half vectors within atan(alpha).
float mirror_roughness(const std::vector<BrdfLobe>& lobes);

}  // namespace maquette
