// Rasterises the index of the visible triangle; resolve.comp computes the rest of the G-buffer once per visible point.
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
layout(location = 0) in vec3 a_position;
#if ALPHA_MASK
layout(location = 1) in vec2 a_uv;
out vec2 v_uv;
#endif
void main() {
  gl_Position = u_frame.clip_from_world * vec4(a_position, 1.0);
#if ALPHA_MASK
  v_uv = a_uv;
#endif
}
