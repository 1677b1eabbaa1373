#pragma once

#include "render/reference/path_scene.h"

namespace maquette {

/// A direction towards light, drawn by importance. What it brings: f cos radiance / pdf, times what comes through.
struct LightDraw {
  glm::vec3 direction{0.0f};  ///< world, unit
  float distance = 0.0f;      ///< m; infinite for the environment
  glm::vec3 radiance{0.0f};   ///< cd/m2; for lights without extent lux, with pdf the probability of choosing the light
  float pdf = 0.0f;           ///< 1/sr; 0: nothing was drawn
  bool has_extent = true;     ///< BRDF samples can hit it
};

/// The environment as this request turns and scales it.
class EnvironmentLight {
 public:
  EnvironmentLight(const TracedEnvironment& environment, const PathOptions& options);
  /// cd/m2 and 1/sr of a world direction (unit).
  glm::vec4 radiance_and_density(const glm::vec3& world) const;
  LightDraw draw(const glm::vec2& u) const;
  bool black() const { return environment_.black; }

 private:
  const TracedEnvironment& environment_;
  float cosine_, sine_, scale_;
};

/// One of the scene's lights, chosen by power; a point of it by area. `mean_emission`: a textured triangle shines with
/// its mean (as the direct modes have it), else as its texture says there.
LightDraw draw_scene_light(const PathScene& scene, const glm::vec3& position, float choice, const glm::vec2& u,
                           bool mean_emission);
/// Density with which draw_scene_light gives the direction from `from` to a point on an emissive triangle; 0 where it
/// is in no list.
float scene_light_pdf(const PathScene& scene, std::uint32_t triangle, const glm::vec3& from, const glm::vec3& to);

}  // namespace maquette
