#include "render/scene_state/material_overrides.h"

namespace maquette {

namespace {

Material make_glass(const Material& replaced) {
  Material glass;
  glass.name = replaced.name;
  glass.glass = true;
  glass.transmission = 1.0f;
  glass.ior = 1.52f;
  glass.roughness = 0.0f;
  glass.metallic = 0.0f;
  glass.double_sided = replaced.double_sided;
  return glass;
}

}  // namespace

std::vector<Material> override_materials(std::vector<Material> materials,
                                         const std::map<std::string, std::string>& sources) {
  for (Material& material : materials) {
    auto found = sources.find(material.name);
    if (found == sources.end()) found = sources.find("*");
    if (found == sources.end()) continue;
    if (found->second == "builtin:glass") {
      material = make_glass(material);
      continue;
    }
    material.measured = found->second;
    material.tint_measured = false;
    material.glass = false;
    material.transmission = 0.0f;
    material.alpha_mode = material.alpha_mode == AlphaMode::blend ? AlphaMode::opaque : material.alpha_mode;
  }
  return materials;
}

float pane_share(const Material& m) { return !m.glass ? 0.0f : m.transmission > 0.0f ? m.transmission : 1.0f; }

}  // namespace maquette
