#include "shared/fresnel.glsl"
in vec3 v_position;
in vec3 v_normal;
uniform vec4 u_cover;  // share that is a pane, refractive index, least internal transmittance, 1 - alpha
layout(location = 0) out float o_through;
void main() {
  vec3 view = normalize(v_position);
  vec3 n = dot(v_normal, v_normal) > 0.0 ? normalize(v_normal) : view;
  o_through = u_cover.x > 0.0 ? u_cover.x * fresnel_pane(abs(dot(n, view)), u_cover.y, u_cover.z).y : u_cover.w;
}
