// Material records: 13 texels of four words each. Written by render/scene_state/scene_buffers.cpp in the same order.
#include "shared/bindings.glsl"
layout(binding = kUnitMaterials) uniform usamplerBuffer t_materials;
const int kMaterialTexels = 13;
const uint kMaterialMeasured = 1u, kMaterialTinted = 2u, kMaterialUnlit = 4u, kMaterialDoubleSided = 8u, kMaterialReplaced = 16u;

vec4 material_floats(int material, int texel) {
  return uintBitsToFloat(texelFetch(t_materials, material * kMaterialTexels + texel));
}
// Texel 0: base colour rgb, alpha cutoff. 1: metallic, roughness, normal scale, occlusion strength. 2: emission rgb, ior.
// 3: clearcoat, coat roughness, specular, transmission. 4: specular colour rgb, sheen roughness. 5: sheen rgb, anisotropy strength.
// 6: flags and (upper half, as a half float) the largest bandwidth of the measured table in cycles/rad, BRDF slot, BRDF sample share (float),
// rotation of the anisotropy, rad. 7: iridescence, its refractive index, least and greatest thickness, nm. 8: coat normal scale, 1 where the
// coat's normal texture has coordinates unlike those of the normal texture.
// 9 to 12: textures. A texture is its record's index with its role in the upper half; the list ends with kNoTexture.
const int kMaterialTextures = 9;  // first texel of the list
const int kMostTextures = 16;
const uint kNoTexture = 0xffffffffu;
const uint kRoleBaseColor = 0u, kRoleMetallicRoughness = 1u, kRoleNormal = 2u, kRoleEmissive = 3u, kRoleOcclusion = 4u,
           kRoleClearcoat = 5u, kRoleCoatRoughness = 6u, kRoleCoatNormal = 7u, kRoleTransmission = 8u, kRoleSpecular = 9u,
           kRoleSpecularColor = 10u, kRoleSheenColor = 11u, kRoleSheenRoughness = 12u, kRoleAnisotropy = 13u, kRoleIridescence = 14u,
           kRoleIridescenceThickness = 15u;
uvec4 material_words(int material, int texel) { return texelFetch(t_materials, material * kMaterialTexels + texel); }
bool has_textures(int material) { return material_words(material, kMaterialTextures).x != kNoTexture; }
uint material_texture(int material, int k) { return material_words(material, kMaterialTextures + (k >> 2))[k & 3]; }
