#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <glm/glm.hpp>
#include <vector>

#include "scenes/scene.h"

namespace maquette {

/// The roles of textures in shading, in the order of shaders/shared/material_table.glsl (kRole...).
enum class TextureRole {
  base_color,
  metallic_roughness,
  normal,
  emissive,
  occlusion,
  clearcoat,
  clearcoat_roughness,
  clearcoat_normal,
  transmission,
  specular,
  specular_color,
  sheen_color,
  sheen_roughness,
  anisotropy,
  iridescence,
  iridescence_thickness,
  thickness
};
inline constexpr std::size_t kTextureRoles = 17;
const TextureRef& texture_of(const Material& material, TextureRole role);
/// Stored in sRGB (its alpha is linear).
bool is_colour(TextureRole role);

/// All textures that shading reads, in the layout of shaders/shared/texture_filter.glsl. Does not use OpenGL.
struct TextureAtlas {
  std::vector<glm::uvec2> texels;  ///< RGBA, 16 bits each, with mip chains; sRGB images as square roots of linear light
  std::vector<glm::vec4> records;     ///< [texture][3]
  std::vector<int> images;            ///< [texture]: index of its image in the scene
  std::vector<std::array<int, kTextureRoles>> of_material;  ///< [material][role], -1: none
};
TextureAtlas build_texture_atlas(const Scene& scene);

}  // namespace maquette
