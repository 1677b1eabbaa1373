#include "shared/bindings.glsl"
uniform int u_first_triangle;
layout(location = 0) out uint o_triangle;
#ifdef PEEL
// The nearest of the surfaces that lie before the opaque ones and behind the layer before (render/glass/blended.cpp).
layout(location = 1) out float o_depth;
layout(binding = kUnitOpaqueDepth) uniform sampler2D t_opaque_depth;
layout(binding = kUnitBlendedDepth) uniform sampler2D t_nearer;
uniform int u_peel;

bool is_peeled() {
  ivec2 at = ivec2(gl_FragCoord.xy);
  return gl_FragCoord.z <= texelFetch(t_opaque_depth, at, 0).x ||
         (u_peel > 0 && gl_FragCoord.z >= texelFetch(t_nearer, at, 0).x);
}
#endif
#if ALPHA_MASK
in float v_alpha;
uniform float u_alpha;
uniform float u_cutoff;
#if ALPHA_MASK == 2
#include "shared/texture_table.glsl"
in vec2 v_uv;
uniform int u_texture;
#endif
void main() {
  float alpha = u_alpha * v_alpha;
#if ALPHA_MASK == 2
  alpha *= sample_texture(u_texture, v_uv, dFdx(v_uv), dFdy(v_uv)).a;
#endif
  if (alpha < u_cutoff) discard;
#ifdef PEEL
  if (is_peeled()) discard;
  o_depth = gl_FragCoord.z;
#endif
  o_triangle = uint(u_first_triangle + gl_PrimitiveID + 1);
}
#else
layout(early_fragment_tests) in;
void main() { o_triangle = uint(u_first_triangle + gl_PrimitiveID + 1); }
#endif
