// A piece that may bend is shown where the mirrored ray of the pixel meets its triangle, at the depth of the path: as far behind the pane as
// the path is long, like what is drawn without a test (projected.vert).
#include "shared/frame.glsl"
#include "reflections/ray_triangle.glsl"
flat in int v_triangle;
flat in int v_steps;
uniform int u_reflector;
layout(location = 0) out uint o_triangle;
layout(location = 1) out uvec2 o_effort;
void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 direction = texelFetch(t_ray_direction, pixel, 0);
  if (int(direction.w) != u_reflector + 1) discard;
  vec4 origin = texelFetch(t_ray_origin, pixel, 0);
  float along_m = distance_to_triangle(origin.xyz, direction.xyz, v_triangle);
  if (along_m < 0.0) discard;
  gl_FragDepth = u_frame.clip_from_world[3].z / (origin.w * (1.0 + along_m / length(origin.xyz - u_frame.eye.xyz)));
  o_triangle = uint(v_triangle + 1);
  o_effort = uvec2(uint(v_steps), 0u);
}
