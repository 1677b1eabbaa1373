/// Radiance as it is stored between passes (base_factor.glsl): `shaded` is the radiance and the luminance of what the base colour scales, for a white
/// base; `surface`: of the G-buffer. TEXTURES 0: the radiance itself.
#include "shared/bindings.glsl"
#if TEXTURES
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/gbuffer.glsl"
#include "shared/luminance.glsl"
#include "shared/material_table.glsl"
#include "bandwidth/base_factor.glsl"
vec4 without_base(vec4 shaded, uvec4 surface) {
  // What is not scaled is the rest of the radiance.
  float white = luminance(shaded.rgb) + shaded.w * (1.0 - luminance(dividing_base(surface)));
  uint flags = material_words(int(surface.z >> 16u), 6).x;
  return with_share(shaded.rgb, surface, tinted_share(vec4(vec3(white), shaded.w), flags));
}
/// For what does not know its share: as under a light that is the same from everywhere.
vec4 without_assumed_base(vec3 radiance, uvec4 surface) {
  uint flags = material_words(int(surface.z >> 16u), 6).x;
  float share = base_color_share(unpack_metallic(surface.z), (flags & kMaterialTinted) != 0u);
  return with_share(radiance, surface, tinted_share(vec4(vec3(1.0), share), flags));
}
#else
vec4 without_base(vec4 shaded, uvec4 surface) { return vec4(shaded.rgb, 1.0); }
vec4 without_assumed_base(vec3 radiance, uvec4 surface) { return vec4(radiance, 1.0); }
#endif
