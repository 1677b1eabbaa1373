#include "viewer/measure/traced_layers.h"

#include "render/math/shared_formulas.h"
#include "render/reference/surface.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

/// Mean of path-traced radiances along a ray.
glm::vec3 mean_radiance(const PathScene& scene, const PathOptions& options, const Ray& ray, int paths,
                        std::uint32_t seed) {
  glm::dvec3 sum(0.0);
  for (int i = 0; i < paths; ++i)
    sum += glm::dvec3(estimate_radiance(scene, options, ray.origin, glm::normalize(ray.direction), seed,
                                        static_cast<std::uint32_t>(i)));
  return glm::vec3(sum / static_cast<double>(paths));
}

/// The ray from where nothing is before the sky.
Ray beyond_scene(const PathScene& scene, const Ray& ray) {
  const glm::vec3 middle = 0.5f * (scene.bounds.min + scene.bounds.max);
  const float reach = glm::length(scene.bounds.max - scene.bounds.min) + glm::distance(ray.origin, middle);
  return {ray.origin + 2.0f * reach * ray.direction, ray.direction};
}

/// What is traced of a ray that ends where a section plane cuts: behind it is the sky.
Ray traced_ray(const PathScene& scene, const Ray& ray, bool meets_something) {
  if (!meets_something) return beyond_scene(scene, ray);
  return {ray.origin + ray.near * ray.direction, ray.direction};
}

/// The ray of the second image, from a little way along it, clear of the pane.
std::optional<Ray> ghost_ray(const SurfacePoint& p, const Ray& ray, const GhostSheet& sheet) {
  const glm::vec3 up = glm::vec3(0.0f, 1.0f, 0.0f) - p.n * p.n.y;
  const bool level = glm::dot(up, up) <= 1e-6f;
  const glm::vec3 back = level ? p.n : glm::normalize(p.n + sheet.wedge_rad * glm::normalize(up));
  const shared::GhostRay ghost = shared::pane_ghost(ray.direction, p.n, back, p.n, p.faces.index.y, sheet.thickness_m);
  if (!ghost.valid || glm::dot(ghost.direction, p.normal) <= 0.0f) return std::nullopt;
  return Ray{p.position + ghost.offset + sheet.thickness_m * ghost.direction, ghost.direction};
}

std::uint32_t seed_of(std::uint32_t seed, std::size_t pixel, std::uint32_t side) {
  // Source: Jarzynski and Olano 2020, "Hash Functions for GPU Rendering", PCG.
  std::uint32_t x = (static_cast<std::uint32_t>(pixel) * 2u + side) ^ (seed * 0x9e3779b9u);
  x = x * 747796405u + 2891336453u;
  x = ((x >> ((x >> 28u) + 4u)) ^ x) * 277803737u;
  return (x >> 22u) ^ x;
}

void set(Image* image, std::size_t pixel, const glm::vec3& value) {
  for (int c = 0; c < 3; ++c)
    image->data[pixel * static_cast<std::size_t>(image->channels) + static_cast<std::size_t>(c)] = value[c];
}

}  // namespace

LayerPictures trace_layers(const PathScene& scene, const PathOptions& options, const EyeRays& rays,
                           const std::vector<std::size_t>& pixels, glm::ivec2 size, int paths, std::uint32_t seed,
                           const std::optional<GhostSheet>& ghost) {
  LayerPictures out{Image(size.x, size.y, 3), Image(size.x, size.y, 3), std::nullopt};
  if (ghost) out.ghost.emplace(size.x, size.y, 3);
  parallel_for(std::size_t{0}, pixels.size(), [&](std::size_t k) {
    const std::size_t pixel = pixels[k];
    const Ray ray = rays.at(pixel);
    const bool cut = ray.far < Ray().far;
    RayHit hit;
    const bool met = intersect(scene, ray, RayKind::camera, 0x80000000u, &hit);
    if (!met || !(scene.material_of(hit.triangle).clear() > 0.0f)) {
      set(&out.transmitted, pixel,
          mean_radiance(scene, options, traced_ray(scene, ray, met || !cut), paths, seed_of(seed, pixel, 0u)));
      return;
    }
    const SurfacePoint p = resolve_surface(scene, ray, hit, {});
    const PaneRays pane = rays_of_pane(p, ray);
    const glm::vec3 mirrored = mean_radiance(scene, options, pane.mirrored, paths, seed_of(seed, pixel, 1u));
    const bool ends = !cut || look_along(scene, ray, {0.0, 1.0, 0.0}).behind.surface;
    const glm::vec3 passed =
        mean_radiance(scene, options, traced_ray(scene, pane.passed, ends), paths, seed_of(seed, pixel, 0u));
    glm::vec3 reflected = p.pane * pane.shares.reflected * mirrored;
    if (ghost) {
      // An opaque inside leaves what the front face mirrors.
      const glm::vec3 back =
          pane.shares.reflected -
          glm::min(shares_of_pane(p.wo.z, p.faces, glm::vec3(0.0f)).reflected, pane.shares.reflected);
      const std::optional<Ray> second = ghost_ray(p, ray, *ghost);
      const glm::vec3 light =
          second ? p.pane * back * mean_radiance(scene, options, *second, paths, seed_of(seed, pixel, 1u))
                 : glm::vec3(0.0f);
      set(&*out.ghost, pixel, light);
      if (ghost->in_reflected) reflected += light - p.pane * back * mirrored;
    }
    set(&out.reflected, pixel, reflected);
    set(&out.transmitted, pixel, p.pane * (pane.shares.transmitted * passed + p.emission));
  });
  return out;
}

}  // namespace maquette
