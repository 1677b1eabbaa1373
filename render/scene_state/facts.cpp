#include "render/scene_state/facts.h"

#include <algorithm>

#include "render/btf/btf_source.h"
#include "render/materials/texture_atlas.h"
#include "render/reflections/reflectors.h"
#include "render/scene_state/enclosure.h"
#include "render/scene_state/material_overrides.h"

namespace maquette {

namespace {

bool has_texture(const Material& material) {
  for (std::size_t k = 0; k < kTextureRoles; ++k)
    if (texture_of(material, static_cast<TextureRole>(k))) return true;
  return false;
}

void add_details(const Material& m, MaterialDetails* details) {
  if (m.unlit || (m.glass && !is_partly_surface(m))) return;
  details->anisotropy |= m.anisotropy > 0.0f;
  details->film |= m.iridescence > 0.0f;
  details->coat_normal |= m.clearcoat > 0.0f && (m.normal_texture || m.clearcoat_normal_texture);
  const bool coat = m.clearcoat > 0.0f && (m.clearcoat_texture || m.clearcoat_roughness_texture);
  const bool specular = m.specular_texture || m.specular_color_texture;
  const bool sheen = m.sheen_color != glm::vec3(0.0f) && (m.sheen_color_texture || m.sheen_roughness_texture);
  details->any |= details->anisotropy || details->film || details->coat_normal || coat || specular || sheen ||
                  (m.occlusion_texture && m.occlusion_strength > 0.0f);
}

bool is_emissive(const Material& material) { return material.emissive != glm::vec3(0.0f); }

/// Marks the materials that something visible uses; the last entry stands for glTF's default material.
std::vector<bool> used_materials(const Scene& scene, int variant) {
  std::vector<bool> used(scene.materials.size() + 1, false);
  const auto mark = [&](int material) {
    const bool named = material >= 0 && material < static_cast<int>(scene.materials.size());
    used[named ? static_cast<std::size_t>(material) : scene.materials.size()] = true;
  };
  for (const Node& node : scene.nodes) {
    if (!node.visible) continue;
    if (node.mesh >= 0) {
      for (const Primitive& primitive : scene.meshes[static_cast<std::size_t>(node.mesh)].primitives)
        mark(material_of(primitive, variant));
    }
    if (node.patch >= 0) mark(scene.patches[static_cast<std::size_t>(node.patch)].material);
  }
  return used;
}

/// Of find_reflectors without names, before it is known which materials mirror.
int count_reflectors(const Scene& scene, int variant) {
  const bool marks = marks_reflectors(scene);
  const auto counts = [&](const Node& node, int material) {
    const bool named = material >= 0 && material < static_cast<int>(scene.materials.size());
    return reflects_unnamed(scene, node, marks, named && scene.materials[static_cast<std::size_t>(material)].glass);
  };
  int count = 0;
  for (const Node& node : scene.nodes) {
    if (!node.visible) continue;
    if (node.patch >= 0) count += counts(node, scene.patches[static_cast<std::size_t>(node.patch)].material);
    if (node.mesh < 0) continue;
    for (const Primitive& primitive : scene.meshes[static_cast<std::size_t>(node.mesh)].primitives)
      count += counts(node, material_of(primitive, variant));
  }
  return count;
}

}  // namespace

float least_roughness(const Material& material) {
  const float base = material.metallic_roughness_texture ? 0.0f : material.roughness;
  if (material.clearcoat <= 0.0f) return base;
  return material.clearcoat_roughness_texture ? 0.0f : std::min(base, material.clearcoat_roughness);
}

void count_tables(const std::vector<Material>& materials, const std::vector<bool>& used, SceneFacts* facts) {
  facts->measured_count = facts->analytic_count = 0;
  facts->has_btf = facts->has_sheen = facts->has_clearcoat = false;
  facts->least_roughness = SceneFacts().least_roughness;
  const Material default_material;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    const Material& material = i < materials.size() ? materials[i] : default_material;
    const bool measured = !material.measured.empty();
    ++(measured ? facts->measured_count : facts->analytic_count);
    facts->has_btf |= is_btf_source(material.measured);
    facts->has_sheen |= !measured && material.sheen_color != glm::vec3(0.0f);
    facts->has_clearcoat |= !measured && material.clearcoat > 0.0f;
    if (!material.glass && material.alpha_mode != AlphaMode::blend)
      facts->least_roughness = std::min(facts->least_roughness, measured ? 0.0f : least_roughness(material));
  }
}

SceneFacts compute_facts(const Scene& scene, int variant) {
  SceneFacts facts;
  facts.triangle_count = count_triangles(scene);
  const std::vector<bool> used = used_materials(scene, variant);
  const Material default_material;
  for (std::size_t i = 0; i < used.size(); ++i) {
    if (!used[i]) continue;
    const Material& material = i < scene.materials.size() ? scene.materials[i] : default_material;
    facts.has_textures |= has_texture(material);
    facts.has_normal_maps |=
        static_cast<bool>(material.normal_texture) || static_cast<bool>(material.clearcoat_normal_texture);
    add_details(material, &facts.details);
    facts.has_mask |= material.alpha_mode == AlphaMode::mask;
    facts.has_glass |= material.glass || material.alpha_mode == AlphaMode::blend;
    facts.has_blended |= (material.glass || material.alpha_mode == AlphaMode::blend) && is_partly_surface(material);
    facts.has_emissive_meshes |= is_emissive(material);
  }
  count_tables(scene.materials, used, &facts);
  facts.reflector_count = count_reflectors(scene, variant);
  for (const Node& node : scene.nodes) {
    if (!node.visible) continue;
    facts.has_punctual_lights |= node.light >= 0;
    facts.has_subdivision |= node.mesh >= 0 && scene.meshes[static_cast<std::size_t>(node.mesh)].cage != nullptr;
  }
  facts.enclosed = is_enclosed(scene, variant);
  return facts;
}

}  // namespace maquette
