#include "render/scene_state/material_overrides.h"

#include <algorithm>

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

/// Unlit: the base colour and its alpha are all that shows, of glass too. Source: KHR_materials_unlit.
void drop_unseen(Material* material) {
  if (!material->unlit) return;
  material->glass = false;
  material->transmission = 0.0f;
  material->clearcoat = 0.0f;
  material->emissive = glm::vec3(0.0f);
  material->emissive_texture = material->occlusion_texture = material->normal_texture = TextureRef();
}

bool is_opaque(const TextureImage& image) {
  for (std::size_t i = 3; i < image.rgba.size(); i += 4)
    if (image.rgba[i] != 255) return false;
  return true;
}

/// Blending only composites, so a material whose alpha is 1 everywhere is an opaque one. Source: glTF 2.0, 3.9.4.
void settle_blending(const Scene& scene, std::vector<Material>* materials) {
  std::vector<bool> covers(materials->size(), true);
  for (const Mesh& mesh : scene.meshes)
    for (const Primitive& primitive : mesh.primitives) {
      const bool opaque = std::all_of(primitive.colors.begin(), primitive.colors.end(),
                                      [](const glm::vec4& color) { return color.a >= 1.0f; });
      if (opaque) continue;
      const auto mark = [&](int material) {
        if (material >= 0 && material < static_cast<int>(covers.size()))
          covers[static_cast<std::size_t>(material)] = false;
      };
      mark(primitive.material);
      for (const auto& [variant, material] : primitive.variant_materials) mark(material);
    }
  for (std::size_t i = 0; i < materials->size(); ++i) {
    Material& m = (*materials)[i];
    if (m.alpha_mode != AlphaMode::blend || !covers[i] || m.base_color.a < 1.0f) continue;
    const TextureRef& texture = m.base_color_texture;
    if (!texture || is_opaque(scene.images[static_cast<std::size_t>(texture.image)])) m.alpha_mode = AlphaMode::opaque;
  }
}

}  // namespace

std::vector<Material> effective_materials(const Scene& scene, const std::map<std::string, std::string>& sources) {
  std::vector<Material> materials = scene.materials;
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
  for (Material& material : materials) drop_unseen(&material);
  settle_blending(scene, &materials);
  return materials;
}

bool is_cut_away(const Material& m) { return m.alpha_mode == AlphaMode::mask && m.base_color.a < m.alpha_cutoff; }

glm::vec3 volume_absorption(const Material& m) {
  if (!(m.thickness > 0.0f)) return glm::vec3(0.0f);
  return -glm::log(glm::max(m.attenuation_color, glm::vec3(1e-20f))) * (m.thickness / m.attenuation_distance);
}

float pane_share(const Material& m) {
  if (!m.glass) return 0.0f;
  if (!(m.transmission > 0.0f)) return 1.0f;
  return m.transmission * (m.metallic_roughness_texture ? 1.0f : 1.0f - m.metallic);
}

bool has_own_coat_tangents(const Material& m) {
  const TextureRef &base = m.normal_texture, &coat = m.clearcoat_normal_texture;
  return base && coat &&
         (base.uv_set != coat.uv_set || base.rotation_rad != coat.rotation_rad || base.scale != coat.scale);
}

bool has_plain_faces(const Material& m) {
  return m.specular == 1.0f && m.specular_color == glm::vec3(1.0f) && m.ior >= 1.0f && !m.specular_texture &&
         !m.specular_color_texture;
}

bool is_partly_surface(const Material& m) {
  const bool metal = m.transmission > 0.0f && m.metallic_roughness_texture && m.metallic > 0.0f;
  return pane_share(m) < 1.0f || m.transmission_texture || metal;
}

}  // namespace maquette
