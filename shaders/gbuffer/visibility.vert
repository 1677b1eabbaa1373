// Rasterises the index of the visible triangle; resolve.comp computes the rest of the G-buffer once per visible point.
// ALPHA_MASK: 1 cuts out by alpha factor and vertex alpha, 2 by a texture as well.
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
layout(location = 0) in vec3 a_position;
#if ALPHA_MASK
#include "gbuffer/vertex.glsl"
out float v_alpha;
#if ALPHA_MASK == 2
uniform int u_texture;
out vec2 v_uv;
#include "shared/texture_table.glsl"
#endif
#endif
void main() {
  gl_Position = u_frame.clip_from_world * vec4(a_position, 1.0);
  gl_ClipDistance[0] = u_frame.section.w - dot(u_frame.section.xyz, a_position);
#if ALPHA_MASK
  v_alpha = vertex_color(gl_VertexID).a;
#endif
#if ALPHA_MASK == 2
  v_uv = texture_coordinates(u_texture, vertex_uv0(gl_VertexID), vertex_uv1(gl_VertexID));
#endif
}
