// Indirect light at a point, interpolated between the vertices it is baked for. Needs shading/visibility.glsl and what that needs.
#include "shared/bindings.glsl"
#include "shared/indirect.glsl"
layout(binding = kUnitIndirect) uniform usamplerBuffer t_indirect;  // [side][vertex], shared/indirect.glsl
uniform int u_bias;
uniform int u_back;  // first entry of the backs, 0: only fronts are baked

IndirectLight load_indirect(VisibilityPoint v) {
  vec3 first = texelFetch(t_vertices, 4 * v.vertices.x + 1).xyz;
  int side = dot(first, v.normal) < 0.0 ? u_back : 0;
  IndirectLight sum;
  sum.mean = sum.red = sum.green = sum.blue = vec3(0.0);
  for (int k = 0; k < 3; ++k) {
    IndirectLight l = unpack_indirect(texelFetch(t_indirect, v.vertices[k] + side), u_bias);
    sum.mean += v.barycentric[k] * l.mean;
    sum.red += v.barycentric[k] * l.red;
    sum.green += v.barycentric[k] * l.green;
    sum.blue += v.barycentric[k] * l.blue;
  }
  if (dot(first, v.normal) < 0.0 && u_back == 0) sum.mean = sum.red = sum.green = sum.blue = vec3(0.0);
  return sum;
}
