/// Radiance without the base factor (base_factor.glsl), as it is stored between passes. TEXTURES 0: the radiance itself.
#include "shared/bindings.glsl"
#if TEXTURES
layout(binding = kUnitSurface) uniform usampler2D t_surface;
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/gbuffer.glsl"
#include "shared/material_table.glsl"
#include "bandwidth/base_factor.glsl"
vec3 without_base(vec3 radiance, ivec2 pixel) {
  uvec4 surface = texelFetch(t_surface, pixel, 0);
  return radiance / base_factor(surface, material_words(int(surface.z >> 16u), 6).x);
}
#else
vec3 without_base(vec3 radiance, ivec2 pixel) { return radiance; }
#endif
