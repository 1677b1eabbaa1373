
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <map>
#include <numbers>

#include "render/frame/camera.h"
#include "render/inspection/light_on_pane.h"
#include "render/reference/path_scene.h"
#include "render/scene_state/material_overrides.h"
#include "scenes/angles.h"
#include "scenes/error.h"
#include "scenes/luminance.h"
#include "scenes/parallel.h"
#include "scenes/suggest.h"
#include "viewer/measure/measure_run.h"
#include "viewer/measure/scene_edits.h"
#include "viewer/session.h"

namespace maquette {

namespace {

constexpr int kBatches = 8;  ///< independent estimates behind an interval

std::string thing_name(const Scene& scene, int node, int material) {
  std::string text = node >= 0 ? scene.nodes[static_cast<std::size_t>(node)].name : "sky";
  if (material >= 0 && static_cast<std::size_t>(material) < scene.materials.size())
    text += ", " + scene.materials[static_cast<std::size_t>(material)].name;
  return text;
}

double luminance_at(const Image& image, std::size_t pixel) {
  const float* p = &image.data[pixel * static_cast<std::size_t>(image.channels)];
  return luminance(glm::dvec3(p[0], p[1], p[2]));
}

}  // namespace

EyeRays eye_rays(const CameraView& camera, int width, int height, const Bounds& bounds) {
  const CameraFrame frame = make_camera_frame(camera, width, height, bounds);
  EyeRays rays;
  const std::size_t count = static_cast<std::size_t>(width) * static_cast<std::size_t>(height);
  rays.origins.resize(count);
  rays.directions.resize(count);
  rays.seen_m.resize(count);
  for (std::size_t i = 0; i < count; ++i) {
    const auto x = static_cast<float>(i % static_cast<std::size_t>(width)),
               y = static_cast<float>(i / static_cast<std::size_t>(width));
    const EyeRay ray = frame.ray_through(
        {(2.0f * x + 1.0f) / static_cast<float>(width) - 1.0f, 1.0f - (2.0f * y + 1.0f) / static_cast<float>(height)});
    rays.origins[i] = ray.origin;
    rays.directions[i] = glm::normalize(ray.direction);
    const glm::vec2 depths = frame.seen_depths(ray);
    rays.seen_m[i] = glm::min(depths, glm::vec2(Ray().far / glm::length(ray.direction))) * glm::length(ray.direction);
  }
  return rays;
}

std::vector<Sight> look_at_all(const PathScene& scene, const EyeRays& rays, const glm::dvec3& up) {
  std::vector<Sight> sights(rays.origins.size());
  parallel_for(std::size_t{0}, sights.size(), [&](std::size_t i) { sights[i] = look_along(scene, rays.at(i), up); });
  return sights;
}

int pane_of(const Scene& scene, const std::string& name, const std::vector<Sight>& sights) {
  std::vector<std::size_t> counts(scene.nodes.size(), 0);
  for (const Sight& sight : sights)
    if (sight.pane) ++counts[static_cast<std::size_t>(sight.pane->node)];
  if (!name.empty()) {
    const int node = find_node(scene, name, "--pane");
    if (counts[static_cast<std::size_t>(node)] == 0)
      throw Error("--pane " + name, "no pixel shows it as the nearest pane", "choose another view or pane");
    return node;
  }
  int most = -1;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] == 0) continue;
    if (scene.nodes[i].name == "windshield") return static_cast<int>(i);
    if (most < 0 || counts[i] > counts[static_cast<std::size_t>(most)]) most = static_cast<int>(i);
  }
  if (most < 0)
    throw Error("maquette measure", "no pixel shows a pane of glass", "choose a view that looks through one");
  return most;
}

std::vector<PictureRegion> checked_regions(const std::vector<PictureRegion>& asked, int width, int height) {
  if (asked.empty()) return {{"pane", 0, 0, width, height}};
  for (const PictureRegion& r : asked)
    if (r.x < 0 || r.y < 0 || r.x + r.width > width || r.y + r.height > height)
      throw UsageError("--region " + r.name,
                       "it reaches outside the picture of " + std::to_string(width) + "x" + std::to_string(height),
                       "give x,y,width,height in pixels from the top left, or another --size");
  return asked;
}

double ghost_arcmin(const PaneSight& pane, const GlassSheet& sheet) {
  // The wedge runs along the pane's line of steepest ascent: only its part in the plane of incidence turns the ray in
  // that plane.
  const glm::dvec3 up = glm::dvec3(0.0, 1.0, 0.0) - pane.normal * pane.normal.y;
  const glm::dvec3 to_eye = sheet.eye - pane.position, along = to_eye - glm::dot(to_eye, pane.normal) * pane.normal;
  const double norm = glm::length(up) * glm::length(along);
  const double part = norm > 1e-12 ? glm::dot(up, along) / norm : 0.0;
  const GhostView view{pane.incidence_rad,
                       pane.refractive_index,
                       sheet.thickness_m,
                       sheet.wedge_rad * part,
                       pane.mirrored.surface ? pane.mirrored.distance_m : std::numeric_limits<double>::infinity(),
                       pane.distance_m};
  return ghost_angle_rad(view) / kArcMinute_rad;
}

namespace {

/// The materials that the pane's pixels mirror, by share.
std::vector<std::pair<std::string, double>> mirrored_shares(const Scene& scene, const std::vector<Sight>& sights,
                                                            const std::vector<std::size_t>& pixels) {
  std::map<std::string, std::size_t> counts;
  for (const std::size_t i : pixels) {
    const Met& met = sights[i].pane->mirrored;
    const bool named =
        met.surface && met.material >= 0 && static_cast<std::size_t>(met.material) < scene.materials.size();
    ++counts[named ? scene.materials[static_cast<std::size_t>(met.material)].name : met.surface ? "(unnamed)" : "sky"];
  }
  std::vector<std::pair<std::string, double>> shares;
  for (const auto& [name, count] : counts)
    shares.emplace_back(name, static_cast<double>(count) / static_cast<double>(pixels.size()));
  std::stable_sort(shares.begin(), shares.end(), [](const auto& a, const auto& b) { return a.second > b.second; });
  return shares;
}

}  // namespace

std::vector<std::size_t> pane_pixels(const PictureRegion& region, int width, int pane,
                                     const std::vector<Sight>& sights) {
  std::vector<std::size_t> pixels;
  for (int y = region.y; y < region.y + region.height; ++y)
    for (int x = region.x; x < region.x + region.width; ++x) {
      const std::size_t i = static_cast<std::size_t>(y) * static_cast<std::size_t>(width) + static_cast<std::size_t>(x);
      if (sights[i].pane && sights[i].pane->node == pane) pixels.push_back(i);
    }
  return pixels;
}

std::optional<double> background_through(const MeasureOptions& options, const Sight& sight) {
  if (!options.background_cdm2 || !sight.pane) return std::nullopt;
  return *options.background_cdm2 * sight.pane->optics.transmitted.mean() *
         polarisation_factor(sight.pane, options.polarisation, false);
}

Error no_pane_in(const PictureRegion& region, const Scene& scene, int pane) {
  return Error("--region " + region.name, "no pixel of it shows the pane " + thing_name(scene, pane, -1),
               "move the region, or name another --pane");
}

RegionValues region_values(const EyeContext& context, const PictureRegion& region, const LayerPictures& pictures,
                           const std::vector<Sight>& sights) {
  const std::vector<std::size_t> pixels = pane_pixels(region, context.width, context.pane, sights);
  RegionValues values;
  values.name = region.name;
  values.box = region;
  if (pixels.empty()) {
    // A step of a sweep may turn the pane out of sight.
    if (!context.options.sweeps.empty()) return values;
    throw no_pane_in(region, context.scene, context.pane);
  }
  values.pane_pixels = pixels.size();
  std::vector<double> reflected, transmitted, sum, incidence, reflectance, ghost;
  double contrast = 0.0, flat = 0.0;
  const MeasureOptions& o = context.options;
  for (const std::size_t i : pixels) {
    const PaneSight& pane = *sights[i].pane;
    reflected.push_back(luminance_at(pictures.reflected, i) *
                        polarisation_factor(sights[i].pane, o.polarisation, true));
    transmitted.push_back(luminance_at(pictures.transmitted, i) *
                          polarisation_factor(sights[i].pane, o.polarisation, false));
    sum.push_back(reflected.back() + transmitted.back());
    incidence.push_back(pane.incidence_rad * 180.0 / std::numbers::pi);
    reflectance.push_back(pane.optics.reflected.mean());
    values.surface_reflectance += pane.optics.surface.mean() / static_cast<double>(pixels.size());
    contrast += contrast_kept(background_through(o, sights[i]).value_or(transmitted.back()), reflected.back());
    if (context.light && o.dash_reflectance)
      flat += flat_veil_cdm2(context.light->illuminance_lx, context.light->transmitted_share, *o.dash_reflectance,
                             pane.optics.reflected.mean());
    if (context.sheet.thickness_m > 0.0) ghost.push_back(std::abs(ghost_arcmin(pane, context.sheet)));
  }
  const auto n = static_cast<double>(pixels.size());
  values.reflected = region_statistics(reflected, o.threshold_cdm2);
  values.transmitted = region_statistics(transmitted, o.threshold_cdm2);
  values.sum = region_statistics(sum, o.threshold_cdm2);
  values.incidence_deg = region_statistics(incidence, 0.0);
  values.reflectance = region_statistics(reflectance, 0.0);
  values.contrast = contrast / n;
  if (context.light && context.light->illuminance_lx > 0.0)
    values.veil_per_lux = values.reflected.mean / context.light->illuminance_lx;
  if (context.light && o.dash_reflectance) values.flat_estimate_cdm2 = flat / n;
  std::erase_if(ghost, [](double angle) { return !std::isfinite(angle); });
  if (!ghost.empty()) values.ghost_arcmin = region_statistics(ghost, 0.0);
  values.mirrored = mirrored_shares(context.scene, sights, pixels);
  return values;
}

TracedValue traced_value(const EyeContext& context, const PathScene& scene, const EyeRays& rays,
                         const std::vector<std::size_t>& pixels, const std::vector<Sight>& sights) {
  const int paths = std::max(1, context.options.paths / kBatches);
  std::vector<double> reflected, transmitted;
  for (int batch = 0; batch < kBatches; ++batch) {
    const LayerPictures traced = trace_layers(scene, context.paths, rays, pixels, {context.width, context.height},
                                              paths, context.seed + 1000u + static_cast<std::uint32_t>(batch));
    double r = 0.0, t = 0.0;
    for (const std::size_t i : pixels) {
      r += luminance_at(traced.reflected, i) * polarisation_factor(sights[i].pane, context.options.polarisation, true);
      t += luminance_at(traced.transmitted, i) *
           polarisation_factor(sights[i].pane, context.options.polarisation, false);
    }
    reflected.push_back(r / static_cast<double>(pixels.size()));
    transmitted.push_back(t / static_cast<double>(pixels.size()));
  }
  return {confidence_interval(reflected), confidence_interval(transmitted), paths * kBatches};
}

ProbeValues probe_values(const EyeContext& context, glm::ivec2 pixel, const LayerPictures& pictures,
                         const std::vector<Sight>& sights) {
  if (pixel.x < 0 || pixel.y < 0 || pixel.x >= context.width || pixel.y >= context.height)
    throw UsageError(
        "--probe " + std::to_string(pixel.x) + "," + std::to_string(pixel.y),
        "it is outside the picture of " + std::to_string(context.width) + "x" + std::to_string(context.height),
        "count from 0 at the top left");
  const std::size_t i =
      static_cast<std::size_t>(pixel.y) * static_cast<std::size_t>(context.width) + static_cast<std::size_t>(pixel.x);
  ProbeValues probe;
  probe.pixel = pixel;
  probe.sight = sights[i];
  probe.reflected =
      luminance_at(pictures.reflected, i) * polarisation_factor(sights[i].pane, context.options.polarisation, true);
  probe.transmitted =
      luminance_at(pictures.transmitted, i) * polarisation_factor(sights[i].pane, context.options.polarisation, false);
  const auto name = [&](const Met& met) {
    return met.surface ? thing_name(context.scene, met.node, met.material) : "sky";
  };
  probe.behind = name(sights[i].behind);
  if (const std::optional<PaneSight>& pane = sights[i].pane) {
    probe.pane = thing_name(context.scene, pane->node, pane->material);
    probe.mirrored = name(pane->mirrored);
    if (context.sheet.thickness_m > 0.0) probe.ghost_arcmin = ghost_arcmin(*pane, context.sheet);
  }
  return probe;
}

}  // namespace maquette
