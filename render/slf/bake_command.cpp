#include "render/slf/bake_command.h"

#include <chrono>
#include <cmath>
#include <cstdio>

#include "render/bake/bake_settings.h"
#include "render/parts/baked_parts.h"
#include "render/reference/path_scene.h"
#include "render/scene_state/material_overrides.h"
#include "render/slf/inspect.h"
#include "render/slf/job.h"
#include "scenes/error.h"

namespace maquette {

std::vector<std::string> light_field_bake_settings() {
  return {"slf.texels", "slf.texels_per_m", "slf.parts", "slf.directions", "slf.paths"};
}

namespace {

double seconds_since(std::chrono::steady_clock::time_point begin) {
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
}

LightFieldJob make_job(const BakeRequest& request, const Settings& settings, const std::string& folder) {
  auto scene = std::make_shared<Scene>(request.scene);
  scene->materials = effective_materials(request.scene, request.materials);
  LightFieldInput input;
  input.scene = input.shown = scene;
  input.geometry = std::make_shared<const FlatGeometry>(flatten(request.scene));
  input.environment = request.environment ? request.environment() : nullptr;
  input.variant = request.variant;
  input.env_rotation_rad = request.env_rotation_rad;
  input.env_scale = request.env_scale;
  if (!input.environment) {
    auto dark = std::make_shared<Environment>();
    dark->width = 32;
    dark->height = 16;
    dark->rgb.assign(32 * 16, glm::vec3(0.0f));
    input.environment = dark;
  }
  LightFieldJob job = make_light_field_job(input, settings);
  if (!request.materials.empty() && folder.empty())
    throw Error("--material", "a render looks in the cache only for light that the scene's own materials reflect",
                "name a folder: -o DIR, and show it with --set slf.bake=DIR");
  if (job.incident.parts.empty())
    throw Error("maquette bake slf", "no opaque surface is left that could get texels", "name other parts: slf.parts");
  job.incident.folder = incident_folder(folder, job.incident);
  if (job.incident.folder.empty()) throw Error("maquette bake", "the cache is switched off", "name a folder: -o DIR");
  job.incident.must_work = job.incident.may_make = true;
  return job;
}

/// Says before the bake what its lumispheres cannot show, and that a material cannot be kept at all.
void check_materials(const LightFieldJob& job, const BakeControl& control) {
  for (const AtlasPart& part : job.incident.parts) {
    const int index = material_of_item(*job.scene, job.incident.geometry->items[part.item], job.incident.variant);
    if (index >= 0) require_light_field_material(job.scene->materials[static_cast<std::size_t>(index)]);
  }
  const LightFieldAtlas atlas = make_atlas(*job.incident.geometry, job.incident.parts, job.incident.atlas);
  const auto scene = build_path_scene({.scene = *job.scene,
                                       .environment = job.incident.environment,
                                       .variant = job.incident.variant,
                                       .geometry = job.incident.geometry.get()});
  for (const std::string& line : warn_of_specular(*scene, atlas, job.incident.options.side))
    control.report("warning: " + line);
  for (const std::string& line : job.left_out) control.report("warning: " + line);
  for (const std::string& line : warn_of_second_uvs(job.incident, atlas)) control.report("warning: " + line);
  char text[160];
  std::snprintf(text, sizeof text, "%zu parts, %zu charts, %zu texels of %.1f mm", job.incident.parts.size(),
                atlas.axes.size(), atlas.texels.size(), atlas.texels_per_m > 0.0 ? 1000.0 / atlas.texels_per_m : 0.0);
  control.report(text);
}

std::string time_left(double share, double seconds) {
  const double left = share > 0.0 ? seconds * (1.0 - share) / share : 0.0;
  char text[40];
  std::snprintf(text, sizeof text, left > 90.0 ? "about %.0f min left" : "about %.0f s left",
                left > 90.0 ? left / 60.0 : left);
  return text;
}

void run(const BakeRequest& request, const BakeControl& control) {
  const std::string& folder = request.folder.empty() ? request.settings.get_string("slf.bake") : request.folder;
  const std::vector<std::string> names = light_field_bake_settings();
  const Settings settings =
      with_settings_of(incident_folder(folder, request.scene.name, ""), request.settings, names, request.given);
  const LightFieldJob job = make_job(request, settings, folder);
  BakeRanks ranks = ranks_from_environment();
  if (ranks.rank == 0 && !folder.empty()) begin_bake_settings(job.incident.folder, settings, names);
  ranks.say = [&](const std::string& text) {
    if (ranks.rank == 0) control.report(text);
  };
  if (ranks.rank == 0) check_materials(job, control);
  const auto begin = std::chrono::steady_clock::now();
  int tenths = -1;
  std::string what = "incident light";
  const auto baked = bake_incident(job.incident, ranks, control.cancel, [&](double share) {
    if (ranks.rank != 0) return;
    if (static_cast<int>(10.0 * share) != tenths) {
      tenths = static_cast<int>(10.0 * share);
      what =
          share > 0.0 && share < 1.0 ? "incident light, " + time_left(share, seconds_since(begin)) : "incident light";
    }
    control.progress(what, share);
  });
  if (!baked) throw Error(job.incident.folder, "the bake was interrupted", "the same command resumes it");
  if (ranks.rank != 0) return;
  std::size_t masked = 0;
  for (const bool m : baked->field.masked) masked += m ? 1 : 0;
  char text[200];
  std::snprintf(text, sizeof text,
                ": %zu texels of %d directions, %zu of them inside other bodies, %.1f s, %zu texels reused",
                baked->atlas.texels.size(), baked->field.bins, masked, seconds_since(begin), baked->reused);
  control.report(job.incident.folder + text);
}

}  // namespace

BakeCommand light_field_bake_command() {
  return {"slf", "light that arrives at the texels of surface light fields; under mpirun processes share the work", run,
          inspect_light_field, true};
}

}  // namespace maquette
