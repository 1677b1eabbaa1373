// Keeps what lies in the pane it was projected into.
layout(binding = 50) uniform sampler2D t_ray_direction;
uniform int u_reflector;
flat in uint v_triangle;
in float v_steps;
layout(location = 0) out uint o_triangle;
layout(location = 1) out uvec2 o_effort;
void main() {
  if (int(texelFetch(t_ray_direction, ivec2(gl_FragCoord.xy), 0).w) != u_reflector + 1) discard;
  o_triangle = v_triangle;
  o_effort = uvec2(uint(v_steps + 0.5), 0u);
}
