#include "render/slf/job.h"

#include <algorithm>

#include "render/parts/baked_parts.h"
#include "render/scene_state/material_overrides.h"
#include "scenes/error.h"

namespace maquette {

LightBasis light_basis(const std::string& name) {
  return name == "bins" ? LightBasis::bins : name == "harmonics" ? LightBasis::harmonics : LightBasis::haar;
}

std::vector<AtlasPart> find_light_field_parts(const LightFieldInput& input, const Settings& settings,
                                              std::vector<std::string>* left_out) {
  const Scene& scene = *input.scene;
  const std::vector<bool> named = named_nodes(scene, settings.get_string("slf.parts"));
  std::vector<AtlasPart> parts;
  for (std::size_t i = 0; i < input.geometry->items.size(); ++i) {
    const DrawItem& item = input.geometry->items[i];
    const Node* node = item.node >= 0 ? &scene.nodes[static_cast<std::size_t>(item.node)] : nullptr;
    if (node && (!node->visible || !named[static_cast<std::size_t>(item.node)])) continue;
    if (node && input.wants && !input.wants(item.node)) continue;
    const int index = material_of_item(scene, item, input.variant);
    const Material material = index >= 0 ? input.shown->materials[static_cast<std::size_t>(index)] : Material();
    if (pane_share(material) > 0.0f || material.alpha_mode == AlphaMode::blend) {
      const bool blended = material.alpha_mode == AlphaMode::blend && !(pane_share(material) > 0.0f);
      const std::string line = "no texels for surfaces of " + material.name +
                               (blended ? ": they are blended, and their own light is missing" : ": they are glass");
      if (left_out && std::ranges::find(*left_out, line) == left_out->end()) left_out->push_back(line);
      continue;
    }
    parts.push_back({i, material.double_sided});
  }
  return parts;
}

LightFieldJob make_light_field_job(const LightFieldInput& input, const Settings& settings) {
  LightFieldJob job;
  IncidentJob& incident = job.incident;
  incident.scene = input.scene;
  incident.geometry = input.geometry;
  incident.environment = input.environment;
  incident.variant = input.variant;
  incident.parts = find_light_field_parts(input, settings, &job.left_out);
  incident.atlas.side = settings.get_int("slf.texels");
  if (!settings.changed().contains("slf.texels")) incident.atlas.texels_per_m = settings.get_double("slf.texels_per_m");
  incident.options.side = settings.get_int("slf.directions");
  incident.options.paths = settings.get_int("slf.paths");
  incident.options.env_rotation_rad = input.env_rotation_rad;
  incident.options.env_scale = input.env_scale;
  const std::string& folder = settings.get_string("slf.bake");
  incident.folder = incident_folder(folder, incident);
  incident.must_work = incident.may_make = false;
  if (folder.empty())
    incident.may_make = true;
  else
    incident.must_work = true;
  incident.show_stale = settings.get_string("slf.stale") == "show";
  job.scene = input.shown;
  job.outgoing.basis = light_basis(settings.get_string("slf.basis"));
  job.outgoing.haar_error = settings.get_double("slf.haar_error");
  job.compression = {settings.get_int("slf.clusters"), settings.get_int("slf.components")};
  job.interactions = settings.get_string("slf.route") == "clusters";
  const int side = incident.options.side;
  if (job.outgoing.basis == LightBasis::haar && (side & (side - 1)) != 0)
    throw Error("slf.directions=" + std::to_string(side), "Haar coefficients need a power of two",
                "take 8, 16 or 32, or another slf.basis");
  return job;
}

}  // namespace maquette
