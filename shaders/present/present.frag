#include "shared/tonemap.glsl"
layout(binding = 24) uniform sampler2D t_picture;
uniform float u_exposure;
uniform int u_curve;      // of tonemap.glsl; -1: the picture is display-encoded already
uniform int u_flip;       // 1: window framebuffers have row 0 at the bottom
in vec2 v_uv;
layout(location = 0) out vec4 o_color;
void main() {
  vec2 uv = u_flip != 0 ? vec2(v_uv.x, 1.0 - v_uv.y) : v_uv;
  vec3 c = texture(t_picture, uv).rgb;
  o_color = vec4(u_curve < 0 ? c : tonemap(c, u_exposure, u_curve), 1.0);
}
