// Everything that is drawn over the opaque picture, to find the least share of that picture that stays visible.
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
layout(location = 0) in vec3 a_position;
layout(binding = kUnitVertices) uniform samplerBuffer t_vertices;
out vec3 v_position;  // m, from where its ray starts
out vec3 v_normal;
void main() {
  gl_Position = u_frame.clip_from_world * vec4(a_position, 1.0);
  gl_ClipDistance[0] = u_frame.section.w - dot(u_frame.section.xyz, a_position);
  v_position = from_eye(a_position);
  v_normal = texelFetch(t_vertices, 4 * gl_VertexID + 1).xyz;
}
