// Rasterises the indices of the visible triangle and its reflector; rays.comp computes the mirrored rays once a pixel.
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
layout(location = 0) in vec3 a_position;
layout(location = 1) in vec2 a_uv;
out vec2 v_uv;
void main() {
  gl_Position = u_frame.clip_from_world * vec4(a_position, 1.0);
  gl_ClipDistance[0] = u_frame.section.w - dot(u_frame.section.xyz, a_position);
  v_uv = a_uv;
}
