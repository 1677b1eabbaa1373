// Baked visibility at a shading point: the masks of its triangle's vertices blended by barycentrics. Per sample one dithered bit index and
// one word of each vertex.
#include "shared/visibility.glsl"
layout(binding = 0) uniform usampler2D t_triangle;
layout(binding = 4) uniform usamplerBuffer t_indices;
layout(binding = 5) uniform samplerBuffer t_vertices;
layout(binding = 25) uniform usamplerBuffer t_visibility;  // [vertex][8] words
layout(binding = 35) uniform samplerBuffer t_transmittance;  // [vertex]: of the panes before the sky, side of +n and of -n

struct VisibilityPoint {
  ivec3 vertices;
  vec3 barycentric;
  vec3 open;    // barycentrics times the transmittance of the panes that each vertex looks through
  vec3 normal;  // of the bake's tangent plane: interpolated from the vertices, turned to the viewer, world
};

VisibilityPoint load_visibility(ivec2 pixel, vec3 position, vec3 normal) {
  int triangle = max(int(texelFetch(t_triangle, pixel, 0).x), 1) - 1;
  ivec3 v = ivec3(texelFetch(t_indices, 3 * triangle).x, texelFetch(t_indices, 3 * triangle + 1).x,
                  texelFetch(t_indices, 3 * triangle + 2).x);
  vec3 p0 = texelFetch(t_vertices, 4 * v.x).xyz;
  vec3 e1 = texelFetch(t_vertices, 4 * v.y).xyz - p0, e2 = texelFetch(t_vertices, 4 * v.z).xyz - p0, d = position - p0;
  float a = dot(e1, e1), b = dot(e1, e2), c = dot(e2, e2), f = dot(d, e1), g = dot(d, e2);
  float inverse = 1.0 / max(a * c - b * b, 1e-30);
  vec2 w = clamp(vec2(c * f - b * g, a * g - b * f) * inverse, 0.0, 1.0);
  w /= max(1.0, w.x + w.y);
  VisibilityPoint r;
  r.vertices = v;
  r.barycentric = vec3(1.0 - w.x - w.y, w);
  // A normal map bends the shading normal only; the masks' horizon is that of the vertices.
  vec3 n = mat3(texelFetch(t_vertices, 4 * v.x + 1).xyz, texelFetch(t_vertices, 4 * v.y + 1).xyz,
                texelFetch(t_vertices, 4 * v.z + 1).xyz) * r.barycentric;
  n = dot(n, n) > 1e-12 ? normalize(n) : normal;
  bool back = dot(n, normal) < 0.0;
  r.normal = back ? -n : n;
  vec2 of_x = texelFetch(t_transmittance, v.x).xy, of_y = texelFetch(t_transmittance, v.y).xy, of_z = texelFetch(t_transmittance, v.z).xy;
  r.open = r.barycentric * (back ? vec3(of_x.y, of_y.y, of_z.y) : vec3(of_x.x, of_y.x, of_z.x));
  return r;
}

/// In [0, 1]; `u` picks the bit (dithering between the cells of the map).
float visibility_of(VisibilityPoint p, vec3 world, vec2 u) {
  int bit = visibility_dithered_bit(world, p.normal, u);
  ivec3 words = 8 * p.vertices + (bit >> 5);
  uvec3 bits = uvec3(texelFetch(t_visibility, words.x).x, texelFetch(t_visibility, words.y).x, texelFetch(t_visibility, words.z).x);
  return dot(p.open, vec3((bits >> uint(bit & 31)) & 1u));
}

/// What visibility_of is on average over `u`: the bits of all four cells, each with its share. `weights`: of the three vertices.
float mean_mask(VisibilityPoint p, vec3 weights, vec3 world) {
  VisibilityCorner corner = visibility_corner(world);
  vec2 f = corner.fraction;
  vec4 share = vec4((1.0 - f.x) * (1.0 - f.y), f.x * (1.0 - f.y), (1.0 - f.x) * f.y, f.x * f.y);
  ivec2 c0 = visibility_wrap(corner.lower), c1 = visibility_wrap(corner.lower + ivec2(1, 0));
  ivec2 c2 = visibility_wrap(corner.lower + ivec2(0, 1)), c3 = visibility_wrap(corner.lower + ivec2(1, 1));
  share = visibility_shares_above(share, abs(f.x - 0.5) < abs(f.y - 0.5), dot(world, p.normal),
                                  vec4(visibility_cell_height(c0, p.normal), visibility_cell_height(c1, p.normal),
                                       visibility_cell_height(c2, p.normal), visibility_cell_height(c3, p.normal)));
  ivec4 bits = ivec4(c0.y, c1.y, c2.y, c3.y) * kVisibilityCells + ivec4(c0.x, c1.x, c2.x, c3.x);
  float sum = 0.0;
  for (int k = 0; k < 3; ++k) {
    ivec4 words = 8 * p.vertices[k] + (bits >> 5);
    uvec4 masks = uvec4(texelFetch(t_visibility, words.x).x, texelFetch(t_visibility, words.y).x, texelFetch(t_visibility, words.z).x,
                        texelFetch(t_visibility, words.w).x);
    sum += weights[k] * dot(share, vec4((masks >> uvec4(bits & 31)) & uvec4(1u)));
  }
  return sum;
}
float mean_visibility(VisibilityPoint p, vec3 world) { return mean_mask(p, p.open, world); }
