// All textures of a scene in one buffer of texels of 4 x 16 bits with their mip chains; filtered in the shader. A texture is read once
// per visible point, so this costs little, and it needs neither bindless textures nor arrays of equal sizes.
#include "shared/bindings.glsl"
layout(binding = kUnitTexels) uniform usamplerBuffer t_texels;
layout(binding = kUnitTextureRecords) uniform samplerBuffer t_texture_records;  // [texture][3], see texture_filter.glsl

uvec2 fetch_texel_words(int index) { return texelFetch(t_texels, index).xy; }
vec4 texture_record(int texture_index, int row) { return texelFetch(t_texture_records, texture_index * 3 + row); }
#include "shared/texture_filter.glsl"
