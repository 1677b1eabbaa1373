// Whether the mirrored ray of the pixel meets the triangle whose box holds it: the paper's false triangles and jagged seams cannot occur,
// as what the box is too large by is taken back here.
#include "reflections/ray_triangle.glsl"
flat in int v_triangle;
flat in int v_reflector;
flat in int v_root;
layout(location = 0) out uint o_triangle;
layout(location = 1) out uvec2 o_effort;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 direction = texelFetch(t_ray_direction, pixel, 0);
  if (int(direction.w) != v_reflector + 1) discard;
  float along_m = distance_to_triangle(texelFetch(t_ray_origin, pixel, 0).xyz, direction.xyz, v_triangle);
  if (along_m < 0.0) discard;
  gl_FragDepth = 1.0 / (1.0 + along_m);
  o_triangle = uint(v_triangle + 1);
  o_effort = uvec2(0u, uint(v_root));
}
