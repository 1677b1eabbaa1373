#pragma once

#include <cstddef>

#include "scenes/scene.h"

namespace maquette {

/// What materials have of the second part of the G-buffer (shaders/shared/gbuffer.glsl), which other scenes do without.
struct MaterialDetails {
  bool any = false;  ///< the others, or textures of occlusion, specular, sheen or the coat's roughness
  bool anisotropy = false, coat_normal = false, film = false;
  bool operator==(const MaterialDetails&) const = default;
};

/// Facts about the scene, counted once when it changes, so that planning a frame costs nothing.
struct SceneFacts {
  std::size_t triangle_count = 0;
  int measured_count = 0;
  int analytic_count = 0;
  bool has_btf = false;
  bool has_textures = false;
  bool has_normal_maps = false;
  bool has_mask = false;
  bool has_glass = false;
  bool has_blended = false;  ///< transparent materials of which a share is a surface
  bool has_sheen = false;    ///< of materials without a table, as the next
  bool has_clearcoat = false;
  MaterialDetails details;
  bool has_punctual_lights = false;
  bool has_emissive_meshes = false;
  bool has_subdivision = false;
  float least_roughness = 1e30f;  ///< of the opaque materials' lobes; 0: of a measured table, which may have any
  int reflector_count = 0;        ///< surfaces that the scene marks, or its panes when it marks none
  bool enclosed = false;          ///< the eye region is closed in (decides shading.visibility = auto)
};
/// Of the narrowest lobe of a material without a table; 0 where a texture may say anything.
float least_roughness(const Material& material);
/// Sets what measured tables have a say in: counts of materials, BTFs, sheen, clearcoat, roughness. `used`: by index,
/// one more for the default material.
void count_tables(const std::vector<Material>& materials, const std::vector<bool>& used, SceneFacts* facts);
SceneFacts compute_facts(const Scene& scene, int variant);

}  // namespace maquette
