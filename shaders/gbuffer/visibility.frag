#include "shared/bindings.glsl"
uniform int u_first_triangle;
layout(location = 0) out uint o_triangle;
#if ALPHA_MASK
#include "shared/texture_table.glsl"
in vec2 v_uv;
uniform int u_texture;
uniform float u_alpha;
uniform float u_cutoff;
void main() {
  vec2 uv = texture_coordinates(u_texture, v_uv, v_uv);
  float alpha = u_alpha * sample_texture(u_texture, uv, dFdx(uv), dFdy(uv)).a;
  if (alpha < u_cutoff) discard;
  o_triangle = uint(u_first_triangle + gl_PrimitiveID + 1);
}
#else
layout(early_fragment_tests) in;
void main() { o_triangle = uint(u_first_triangle + gl_PrimitiveID + 1); }
#endif
