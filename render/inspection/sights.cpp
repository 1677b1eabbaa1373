#include "render/inspection/sights.h"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "render/inspection/light_on_pane.h"
#include "render/reference/surface.h"
#include "scenes/luminance.h"
#include "scenes/parallel.h"

namespace maquette {

namespace {

constexpr int kMostPanes = 16;

/// Mean of a pane's optics over the channels, weighted as luminance weighs neutral light.
PaneOptics optics_of(const SurfacePoint& p) {
  constexpr double kWeights[] = {0.2126, 0.7152, 0.0722};
  PaneOptics mean;
  for (int c = 0; c < 3; ++c) {
    const double inside = std::clamp(static_cast<double>(p.base_color[c]), 0.0, 1.0);
    PaneOptics o = pane_optics(std::acos(std::clamp(static_cast<double>(p.wo.z), 0.0, 1.0)),
                               static_cast<double>(p.faces.index[c]), inside);
    if (!shared::is_plain(p.faces)) {  // the share of KHR_materials_specular: as the renderer has it, unpolarised
      const PaneShares shares = shares_of_pane(p.wo.z, p.faces, glm::clamp(p.base_color, 0.0f, 1.0f));
      const double r = static_cast<double>(shares.reflected[c]), t = static_cast<double>(shares.transmitted[c]);
      o.reflected = {r, r};
      o.transmitted = {t, t};
    }
    for (auto part : {&PaneOptics::surface, &PaneOptics::reflected, &PaneOptics::transmitted}) {
      (mean.*part).s += kWeights[c] * (o.*part).s;
      (mean.*part).p += kWeights[c] * (o.*part).p;
    }
  }
  return mean;
}

Met met_at(const PathScene& scene, const RayHit& hit, const Ray& ray, double before_m) {
  const DrawItem& item = item_of_triangle(scene.geometry, scene.triangles[hit.triangle].source);
  const double length = static_cast<double>(glm::length(ray.direction));
  return {true, item.node, static_cast<int>(scene.triangles[hit.triangle].material & ~kBothSides),
          before_m + static_cast<double>(hit.distance) * length,
          glm::dvec3(ray.origin) + glm::dvec3(ray.direction) * static_cast<double>(hit.distance)};
}

/// What lies along a ray behind all panes.
Met follow(const PathScene& scene, Ray ray, RayKind kind, double before_m) {
  for (int k = 0; k < kMostPanes; ++k) {
    RayHit hit;
    if (!intersect(scene, ray, kind, 0x80000000u, &hit)) return {};
    if (!(scene.material_of(hit.triangle).clear() > 0.0f)) return met_at(scene, hit, ray, before_m);
    const SurfacePoint p = resolve_surface(scene, ray, hit, {});
    before_m += static_cast<double>(glm::distance(ray.origin, p.position));
    ray.origin = offset_from_surface(p.position, p.error, -p.normal);
    ray.near = 0.0f;
    ray.far = std::max(ray.far - hit.distance, 0.0f);
  }
  return {};
}

PaneSight pane_sight(const PathScene& scene, const Ray& ray, const RayHit& hit, const glm::dvec3& up) {
  const SurfacePoint p = resolve_surface(scene, ray, hit, {});
  const Met here = met_at(scene, hit, ray, 0.0);
  PaneSight sight;
  sight.node = here.node;
  sight.material = here.material;
  sight.position = glm::dvec3(p.position);
  sight.normal = glm::dvec3(p.n);
  sight.distance_m = here.distance_m;
  sight.incidence_rad = std::acos(std::clamp(static_cast<double>(p.wo.z), 0.0, 1.0));
  sight.refractive_index = static_cast<double>(p.faces.index.y);
  sight.inside = luminance(glm::dvec3(glm::clamp(p.base_color, 0.0f, 1.0f)));
  sight.optics = optics_of(p);
  // s-polarised light swings across the plane of incidence; the polariser passes what swings along `up`.
  const glm::dvec3 view = glm::normalize(glm::dvec3(ray.direction));
  const glm::dvec3 s = glm::cross(view, sight.normal), axis = up - glm::dot(up, view) * view;
  const double ss = glm::dot(s, s), aa = glm::dot(axis, axis), along = glm::dot(s, axis);
  sight.s_through_sunglasses = ss * aa > 1e-18 ? along * along / (ss * aa) : 0.5;
  sight.mirrored = follow(scene, rays_of_pane(p, ray).mirrored, RayKind::path, 0.0);
  return sight;
}

}  // namespace

Sight look_along(const PathScene& scene, const Ray& ray, const glm::dvec3& up) {
  Sight sight;
  RayHit hit;
  if (intersect(scene, ray, RayKind::camera, 0x80000000u, &hit) && scene.material_of(hit.triangle).clear() > 0.0f)
    sight.pane = pane_sight(scene, ray, hit, up);
  sight.behind = follow(scene, ray, RayKind::camera, 0.0);
  return sight;
}

double polarisation_factor(const std::optional<PaneSight>& pane, Polarisation polarisation, bool reflected) {
  if (polarisation == Polarisation::all) return 1.0;
  if (!pane) return polarisation == Polarisation::sunglasses ? 0.5 : 1.0;
  const Polarised& part = reflected ? pane->optics.reflected : pane->optics.transmitted;
  if (!(part.mean() > 0.0)) return 0.0;
  if (polarisation == Polarisation::s) return part.s / part.mean();
  if (polarisation == Polarisation::p) return part.p / part.mean();
  const double share = pane->s_through_sunglasses;
  return 0.5 * (part.s * share + part.p * (1.0 - share)) / part.mean();
}

std::optional<PaneLight> light_on_pane(const PathScene& scene, const Environment& environment, float rotation_rad,
                                       float env_scale, int node, const glm::dvec3& inside_m) {
  // Points at equal steps of area over the pane's triangles.
  constexpr std::size_t kPoints = 16;
  struct Facet {
    std::uint32_t triangle;
    double area;
    glm::dvec3 middle{}, normal{};
  };
  std::vector<Facet> facets;
  PaneLight light;
  double area = 0.0;
  for (std::uint32_t t = 0; t < scene.triangles.size(); ++t) {
    const TracedTriangle& traced = scene.triangles[t];
    if (!(scene.material_of(t).clear() > 0.0f) || item_of_triangle(scene.geometry, traced.source).node != node)
      continue;
    const glm::dvec3 a(traced.positions[0]), b(traced.positions[1]), c(traced.positions[2]);
    const glm::dvec3 cross = glm::cross(b - a, c - a), middle = (a + b + c) / 3.0;
    const double twice = glm::length(cross);
    if (!(twice > 0.0)) continue;
    const glm::dvec3 normal = cross / (glm::dot(cross, middle - inside_m) > 0.0 ? twice : -twice);
    facets.push_back({t, 0.5 * twice, middle, normal});
    area += 0.5 * twice;
    light.normal += 0.5 * twice * normal;
    light.middle += 0.5 * twice * middle;
    light.lowest_m = std::min({facets.size() == 1 ? a.y : light.lowest_m, a.y, b.y, c.y});
  }
  if (facets.empty()) return std::nullopt;
  light.normal = glm::normalize(light.normal);
  light.middle /= area;
  light.rake_deg = std::asin(std::clamp(light.normal.y, -1.0, 1.0)) * 180.0 / std::numbers::pi;
  std::vector<Facet> chosen;
  double reached = 0.0;
  for (const Facet& facet : facets) {
    reached += facet.area;
    while (chosen.size() < kPoints && reached >= (static_cast<double>(chosen.size()) + 0.5) * area / kPoints)
      chosen.push_back(facet);
  }
  struct Sum {
    double shadowed = 0.0, plain = 0.0, through = 0.0;
  };
  std::vector<Sum> sums(chosen.size());
  const std::vector<DistantLight> lights =
      distant_lights(environment, static_cast<double>(rotation_rad), static_cast<double>(env_scale));
  parallel_for(std::size_t{0}, chosen.size(), [&](std::size_t k) {
    const Facet& f = chosen[k];
    const glm::dvec3 view = glm::normalize(inside_m - f.middle);
    const Ray towards{glm::vec3(f.middle + 0.01 * view), glm::vec3(-view)};
    RayHit hit;
    double inside = 1.0, index = 1.0;
    if (intersect(scene, towards, RayKind::path, 0u, &hit) && scene.material_of(hit.triangle).clear() > 0.0f) {
      const SurfacePoint p = resolve_surface(scene, towards, hit, {});
      inside = luminance(glm::dvec3(glm::clamp(p.base_color, 0.0f, 1.0f)));
      index = static_cast<double>(p.faces.index.y);
    }
    for (const DistantLight& d : lights) {
      const double cosine = glm::dot(d.direction, f.normal);
      if (!(cosine > 0.0)) continue;
      sums[k].plain += d.illuminance_lx * cosine;
      RayHit blocked;
      if (find_opaque(scene, {glm::vec3(f.middle + 1e-3 * f.normal), glm::vec3(d.direction)}, &blocked)) continue;
      sums[k].shadowed += d.illuminance_lx * cosine;
      sums[k].through += d.illuminance_lx * cosine * pane_optics(std::acos(cosine), index, inside).transmitted.mean();
    }
  });
  double through = 0.0;
  for (const Sum& sum : sums) {
    light.illuminance_lx += sum.shadowed / static_cast<double>(sums.size());
    light.unshadowed_lx += sum.plain / static_cast<double>(sums.size());
    through += sum.through / static_cast<double>(sums.size());
  }
  light.transmitted_share = light.illuminance_lx > 0.0 ? through / light.illuminance_lx : 0.0;
  return light;
}

}  // namespace maquette
