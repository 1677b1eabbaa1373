// Triangles that a projecting technique has placed behind the pane. All lie on the same z, the near plane's (reversed depth, no far plane):
// in its place they carry the steps of the search.
#include "shared/frame.glsl"
layout(binding = 55) uniform samplerBuffer t_drawn;  // 4 texels a triangle: three clip positions | heights, number
flat out uint v_triangle;
out float v_steps;
out gl_PerVertex {
  vec4 gl_Position;
  float gl_ClipDistance[1];
};
void main() {
  int triangle = gl_VertexID / 3, corner = gl_VertexID - 3 * triangle;
  vec4 rest = texelFetch(t_drawn, 4 * triangle + 3);
  gl_Position = texelFetch(t_drawn, 4 * triangle + corner);
  v_steps = gl_Position.z;
  gl_Position.z = u_frame.clip_from_world[3].z;
  gl_ClipDistance[0] = rest[corner];  // behind the tangent plane of its reflection point nothing is reflected
  v_triangle = uint(rest.w + 0.5);
}
