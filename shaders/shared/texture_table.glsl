// All textures of a scene in one buffer of packed RGBA8 texels with their mip chains; filtered in the shader. A texture is read once
// per visible point, so this costs little, and it needs neither bindless textures nor arrays of equal sizes.
#include "shared/bindings.glsl"
layout(binding = kUnitTexels) uniform usamplerBuffer t_texels;
layout(binding = kUnitTextureRecords) uniform samplerBuffer t_texture_records;  // [texture][3], see texture_filter.glsl

uint fetch_texel_word(int index) { return texelFetch(t_texels, index).x; }
vec4 texture_record(int texture_index, int row) { return texelFetch(t_texture_records, texture_index * 3 + row); }
#include "shared/texture_filter.glsl"
