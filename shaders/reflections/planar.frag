// Keeps what lies in the mirror that it is mirrored in.
layout(binding = 50) uniform sampler2D t_ray_direction;
uniform int u_reflector;
uniform int u_first_triangle;
layout(location = 0) out uint o_triangle;
layout(location = 1) out uvec2 o_effort;
void main() {
  if (int(texelFetch(t_ray_direction, ivec2(gl_FragCoord.xy), 0).w) != u_reflector + 1) discard;
  o_triangle = uint(u_first_triangle + gl_PrimitiveID + 1);
  o_effort = uvec2(0u);
}
