// Baked visibility at a shading point: the masks of its triangle's vertices blended by barycentrics, one bit a sample.
#include "shared/visibility.glsl"
layout(binding = 0) uniform usampler2D t_triangle;
layout(binding = 4) uniform usamplerBuffer t_indices;
layout(binding = 5) uniform samplerBuffer t_vertices;
layout(binding = 25) uniform usamplerBuffer t_visibility;  // [vertex][8] words

struct VisibilityPoint {
  ivec3 words;       // first word of each vertex
  vec3 barycentric;
  vec3 normal;       // world
};

VisibilityPoint load_visibility(ivec2 pixel, vec3 position, vec3 normal) {
  int triangle = int(texelFetch(t_triangle, pixel, 0).x) - 1;
  ivec3 v = ivec3(texelFetch(t_indices, 3 * triangle).x, texelFetch(t_indices, 3 * triangle + 1).x,
                  texelFetch(t_indices, 3 * triangle + 2).x);
  vec3 p0 = texelFetch(t_vertices, 4 * v.x).xyz;
  vec3 e1 = texelFetch(t_vertices, 4 * v.y).xyz - p0, e2 = texelFetch(t_vertices, 4 * v.z).xyz - p0, d = position - p0;
  float a = dot(e1, e1), b = dot(e1, e2), c = dot(e2, e2), f = dot(d, e1), g = dot(d, e2);
  float inverse = 1.0 / max(a * c - b * b, 1e-30);
  vec2 w = clamp(vec2(c * f - b * g, a * g - b * f) * inverse, 0.0, 1.0);
  w /= max(1.0, w.x + w.y);
  VisibilityPoint r;
  r.words = 8 * v;
  r.barycentric = vec3(1.0 - w.x - w.y, w);
  r.normal = normal;
  return r;
}

float visibility_of(VisibilityPoint p, vec3 world, vec2 u) {
  int bit = visibility_dithered_bit(world, p.normal, u);
  int word = bit >> 5;
  uint shift = uint(bit & 31);
  return p.barycentric.x * float((texelFetch(t_visibility, p.words.x + word).x >> shift) & 1u) +
         p.barycentric.y * float((texelFetch(t_visibility, p.words.y + word).x >> shift) & 1u) +
         p.barycentric.z * float((texelFetch(t_visibility, p.words.z + word).x >> shift) & 1u);
}
