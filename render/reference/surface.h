#pragma once

#include <algorithm>
#include <cmath>

#include "render/math/surface_formulas.h"
#include "render/reference/path_scene.h"
#include "render/reference/traversal.h"

namespace maquette {

inline float largest(const glm::vec3& v) { return std::max({v.x, v.y, v.z}); }
inline bool is_finite(const glm::vec3& v) { return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z); }

/// A surface point with its material after textures, ready for shading.
struct SurfacePoint {
  glm::vec3 position{0.0f};
  glm::vec3 error{0.0f};                ///< bound of the rounding error of each coordinate
  glm::vec3 normal{0.0f};               ///< geometric, unit, on the side that the ray came from
  glm::vec3 n{0.0f}, t{0.0f}, b{0.0f};  ///< shading frame
  glm::vec3 wo{0.0f};                   ///< local, unit, z > 0
  const TracedMaterial* material = nullptr;
  std::uint32_t triangle = 0;
  bool front = true;             ///< seen from the front, by the winding
  bool normal_adjusted = false;  ///< n was changed to face this viewer, and differs for others
  glm::vec3 base_color{1.0f};
  glm::vec3 emission{0.0f};  ///< cd/m2 towards wo
  glm::vec3 tint{1.0f};      ///< of a measured table
  float occlusion = 1.0f;    ///< of the environment's light, for direct transport; full transport has real occlusion
  float pane = 0.0f;         ///< share that is glass
  float thickness = 1.0f;    ///< of its volume: factor of the texture
  BtfLookup btf;             ///< where its BTF is read, if it has one
  // Without a measured table; of a BTF, what directions are drawn by:
  shared::AnalyticMaterial analytic{};
  glm::vec3 lobe_weights{1.0f, 0.0f, 0.0f};
  shared::PaneFaces faces{glm::vec3(1.0f), 1.0f};  ///< of glass

  glm::vec3 to_local(const glm::vec3& d) const { return {glm::dot(t, d), glm::dot(b, d), glm::dot(n, d)}; }
  glm::vec3 to_world(const glm::vec3& w) const { return t * w.x + b * w.y + n * w.z; }
};

struct SurfaceOptions {
  const RayDifferential* differential = nullptr;  ///< null: textures unfiltered
};

/// Writes to `out`. Fields that the material does not use (the tint, or the analytic material and its lobes) keep their
/// values.
void resolve_surface(const PathScene& scene, const Ray& ray, const RayHit& hit, const SurfaceOptions& options,
                     SurfacePoint* out);
inline SurfacePoint resolve_surface(const PathScene& scene, const Ray& ray, const RayHit& hit,
                                    const SurfaceOptions& options) {
  SurfacePoint point;
  resolve_surface(scene, ray, hit, options, &point);
  return point;
}

/// Transmittance per channel of a pane at a hit, straight through; `view`: unit, to either side.
glm::vec3 pane_transmittance(const PathScene& scene, std::uint32_t triangle, const glm::vec2& barycentric,
                             const glm::vec3& view);

/// Alpha of a surface at barycentric coordinates of its triangle, as the mean of the ray's footprint.
float alpha_at(const PathScene& scene, std::uint32_t triangle, const glm::vec2& barycentric,
               const RayDifferential& differential);

/// Emitted radiance at barycentric coordinates of a triangle, texture unfiltered.
glm::vec3 emission_at(const PathScene& scene, std::uint32_t triangle, const glm::vec2& barycentric);

/// Reflectance and transmittance of a pane per channel. `inside`: internal transmittance of one crossing.
using shared::PaneShares;
PaneShares shares_of_pane(float cosine, const shared::PaneFaces& faces, const glm::vec3& inside);

/// The reflected and the transmitted ray of a pane that was hit at `p`, with their shares.
struct PaneRays {
  Ray mirrored, passed;
  PaneShares shares{};
};

PaneRays rays_of_pane(const SurfacePoint& p, const Ray& ray);

}  // namespace maquette
