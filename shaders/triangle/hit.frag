// Whether the mirrored ray of the pixel meets the triangle whose box holds it: the paper's false triangles and jagged seams cannot occur,
// as what the box is too large by is taken back here.
layout(binding = 4) uniform usamplerBuffer t_indices;
layout(binding = 5) uniform samplerBuffer t_vertices;
layout(binding = 49) uniform sampler2D t_ray_origin;
layout(binding = 50) uniform sampler2D t_ray_direction;  // w: reflector + 1
flat in int v_triangle;
flat in int v_reflector;
flat in int v_root;
layout(location = 0) out uint o_triangle;
layout(location = 1) out uvec2 o_effort;

/// Neither may a ray slip through between two triangles by rounding.
const float kSeam = 1e-5;
/// As far away nothing is seen of what touches the reflector, m.
const float kNear_m = 1e-4;

void main() {
  ivec2 pixel = ivec2(gl_FragCoord.xy);
  vec4 direction = texelFetch(t_ray_direction, pixel, 0);
  if (int(direction.w) != v_reflector + 1) discard;
  vec3 origin = texelFetch(t_ray_origin, pixel, 0).xyz;
  vec3 a = texelFetch(t_vertices, 4 * int(texelFetch(t_indices, 3 * v_triangle).x)).xyz;
  vec3 b = texelFetch(t_vertices, 4 * int(texelFetch(t_indices, 3 * v_triangle + 1).x)).xyz;
  vec3 c = texelFetch(t_vertices, 4 * int(texelFetch(t_indices, 3 * v_triangle + 2).x)).xyz;
  // Moller and Trumbore 1997.
  vec3 e1 = b - a, e2 = c - a, q = cross(direction.xyz, e2), s = origin - a, r = cross(s, e1);
  float determinant = dot(e1, q);
  if (abs(determinant) < 1e-30) discard;
  float inverse = 1.0 / determinant;
  vec3 hit = vec3(dot(s, q), dot(direction.xyz, r), dot(e2, r)) * inverse;
  if (hit.x < -kSeam || hit.y < -kSeam || hit.x + hit.y > 1.0 + kSeam || hit.z < kNear_m) discard;
  gl_FragDepth = 1.0 / (1.0 + hit.z);
  o_triangle = uint(v_triangle + 1);
  o_effort = uvec2(0u, uint(v_root));
}
