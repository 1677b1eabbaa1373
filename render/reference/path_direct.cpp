// Restricted transport: the quantity that `uniform` with shading.visibility=none estimates, without its approximations.
#include <algorithm>
#include <cmath>

#include "render/reference/path.h"
#include "render/reference/scattering.h"
#include "render/scene_state/material_overrides.h"

namespace maquette {

namespace {

constexpr int kMostLayers = 64;  ///< panes and blended surfaces in front of an opaque surface
constexpr std::uint32_t kDimensionsALayer = 8;

glm::vec3 balanced(const glm::vec3& value, float pdf, float other) { return value / (pdf + other); }

/// One sample of the environment and one of the BRDF, weighted by the balance heuristic; one of the scene's lights,
/// which occlusion textures do not dim (glTF 2.0, 3.9.3).
glm::vec3 reflect_unshadowed(const PathScene& scene, const EnvironmentLight& environment, const PathSampler& sampler,
                             std::uint32_t dimension, const SurfacePoint& p) {
  glm::vec3 sum(0.0f);
  if (!environment.black()) {
    LightDraw light = environment.draw(sampler.pair(dimension));
    environment.fill(&light);
    const glm::vec3 wi = p.to_local(light.direction);
    const Scattering s = evaluate_scattering(p, wi);
    if (wi.z > 0.0f) sum += balanced(s.f * wi.z * light.radiance * p.occlusion, light.pdf, s.pdf);
  }
  const ScatteringSample s = sample_scattering(p, sampler.pair(dimension + 1));
  if (s.pdf > 0.0f && !environment.black()) {
    const glm::vec4 light = environment.radiance_and_density(p.to_world(s.wi));
    sum += balanced(s.f * s.wi.z * glm::vec3(light) * p.occlusion, s.pdf, light.w);
  }
  if (!scene.lights.lights.empty()) {
    const LightPick pick = choose_light(scene.lights, light_cell(scene.lights, p.position),
                                        sampler.single(dimension + 3), sampler.word(dimension + 3));
    const LightDraw light = draw_scene_light(scene, p.position, pick, sampler.pair(dimension + 4), true);
    const glm::vec3 wi = p.to_local(light.direction);
    if (light.pdf > 0.0f && wi.z > 0.0f) sum += evaluate_scattering(p, wi).f * wi.z * light.radiance / light.pdf;
  }
  return sum;
}

/// What a volume lets through on the way of the refracted ray through a slab of its thickness: panes stand for its
/// faces.
glm::vec3 kept_inside(const PathScene& scene, const SurfacePoint& p) {
  if (!p.front) return glm::vec3(1.0f);
  const float ior = std::max(p.material->values.ior, 1.0f), c = p.wo.z;
  const float way = p.thickness * item_of_triangle(scene.geometry, scene.triangles[p.triangle].source).scale /
                    std::sqrt(std::max(1.0f - (1.0f - c * c) / (ior * ior), 1e-6f));
  return glm::exp(-volume_absorption(p.material->values) * way);
}

}  // namespace

PathEstimate estimate_direct(const PathScene& scene, const EnvironmentLight& environment, const PathSampler& sampler,
                             const Ray& camera_ray, const RayDifferential* differential) {
  PathEstimate result;
  Ray ray = camera_ray;
  glm::vec3 through(1.0f);
  for (int layer = 0; layer < kMostLayers; ++layer) {
    const std::uint32_t dimension = 1 + static_cast<std::uint32_t>(layer) * kDimensionsALayer;
    RayHit hit;
    ++result.rays;
    if (!intersect(scene, ray, RayKind::camera, 0, &hit, differential)) {
      result.radiance += through * glm::vec3(environment.radiance_and_density(glm::normalize(ray.direction)));
      return result;
    }
    const SurfacePoint p = resolve_surface(scene, ray, hit, {differential});
    const TracedMaterial& m = *p.material;
    float alpha = 1.0f;
    if (m.blended)
      alpha = differential ? alpha_at(scene, hit.triangle, hit.barycentric, *differential)
                           : alpha_at(scene, hit.triangle, hit.barycentric);
    glm::vec3 shown = p.emission;
    if (p.pane < 1.0f)
      shown += (1.0f - p.pane) *
               (m.values.unlit ? p.base_color : reflect_unshadowed(scene, environment, sampler, dimension, p));
    if (m.pane <= 0.0f && !m.blended) {
      result.covered = true;
      result.radiance += through * shown;
      return result;
    }
    glm::vec3 behind(1.0f - alpha);
    if (m.pane > 0.0f) {
      const PaneShares shares =
          shares_of_pane(p.wo.z, p.faces, glm::clamp(p.base_color, 0.0f, 1.0f) * kept_inside(scene, p));
      const glm::vec3 mirrored = p.to_world({-p.wo.x, -p.wo.y, p.wo.z});
      shown += p.pane * shares.reflected * glm::vec3(environment.radiance_and_density(mirrored));
      behind += alpha * p.pane * shares.transmitted;
    }
    result.radiance += through * alpha * shown;
    through *= behind;
    ray.origin = offset_from_surface(p.position, p.error, -p.normal);
    ray.near = 0.0f;
  }
  return result;
}

}  // namespace maquette
