// Baked visibility at a shading point: the visibility maps of its triangle's vertices, blended by barycentrics. A direction reads one word of each
// vertex.
#include "shared/bindings.glsl"
#include "shared/visibility.glsl"
layout(binding = kUnitTriangle) uniform usampler2D t_triangle;
layout(binding = kUnitIndices) uniform usamplerBuffer t_indices;
layout(binding = kUnitVertices) uniform samplerBuffer t_vertices;
layout(binding = kUnitVisibility) uniform usamplerBuffer t_visibility;  // [vertex][side of +n, of -n][kVisibilityWords]
layout(binding = kUnitTransmittance) uniform samplerBuffer t_transmittance;  // [vertex]: of the panes before the sky, side of +n and of -n

struct VisibilityPoint {
  ivec3 vertices;
  ivec3 words;  // first of each vertex's side
  vec3 barycentric;
  vec3 open;    // barycentrics times the transmittance of the panes between each vertex and the sky
  vec3 normal;  // of the bake's tangent plane: interpolated from the vertices, turned to the viewer, world
};

VisibilityPoint load_visibility(ivec2 pixel, vec3 position, vec3 normal) {
  int triangle = max(int(texelFetch(t_triangle, pixel, 0).x), 1) - 1;
  ivec3 v = ivec3(texelFetch(t_indices, 3 * triangle).x, texelFetch(t_indices, 3 * triangle + 1).x,
                  texelFetch(t_indices, 3 * triangle + 2).x);
  vec3 p0 = texelFetch(t_vertices, 4 * v.x).xyz;
  vec3 e1 = texelFetch(t_vertices, 4 * v.y).xyz - p0, e2 = texelFetch(t_vertices, 4 * v.z).xyz - p0, d = position - p0;
  // In units of the longer edge: in metres, fourth powers of the edges of a triangle of 1e-8 m would underflow.
  float unit = inversesqrt(max(max(dot(e1, e1), dot(e2, e2)), 1e-36));
  e1 *= unit, e2 *= unit, d *= unit;
  float a = dot(e1, e1), b = dot(e1, e2), c = dot(e2, e2), f = dot(d, e1), g = dot(d, e2);
  float inverse = 1.0 / max(a * c - b * b, 1e-30);
  vec2 w = clamp(vec2(c * f - b * g, a * g - b * f) * inverse, 0.0, 1.0);
  w /= max(1.0, w.x + w.y);
  VisibilityPoint r;
  r.vertices = v;
  r.barycentric = vec3(1.0 - w.x - w.y, w);
  // A normal map changes the shading normal only; the horizon of the visibility maps is that of the vertex normals.
  vec3 n = mat3(texelFetch(t_vertices, 4 * v.x + 1).xyz, texelFetch(t_vertices, 4 * v.y + 1).xyz,
                texelFetch(t_vertices, 4 * v.z + 1).xyz) * r.barycentric;
  n = dot(n, n) > 1e-12 ? normalize(n) : normal;
  bool back = dot(n, normal) < 0.0;
  r.normal = back ? -n : n;
  r.words = kVisibilityWords * (2 * v + (back ? 1 : 0));
  vec2 of_x = texelFetch(t_transmittance, v.x).xy, of_y = texelFetch(t_transmittance, v.y).xy, of_z = texelFetch(t_transmittance, v.z).xy;
  r.open = r.barycentric * (back ? vec3(of_x.y, of_y.y, of_z.y) : vec3(of_x.x, of_y.x, of_z.x));
  return r;
}

/// The three vertices' bits of the four cells around a direction, blended. `weights`: of the vertices.
vec4 blended_bits(VisibilityPoint p, vec3 weights, VisibilityCorner corner) {
  VisibilityBitPosition place = visibility_bit_position(corner.lower);
  ivec3 words = p.words + place.word;
  uvec3 bits = uvec3(texelFetch(t_visibility, words.x).x, texelFetch(t_visibility, words.y).x, texelFetch(t_visibility, words.z).x);
  return weights.x * visibility_bits(bits.x, place.shift) + weights.y * visibility_bits(bits.y, place.shift) +
         weights.z * visibility_bits(bits.z, place.shift);
}

/// Bilinear value of the vertices' visibility maps, in [0, 1].
float interpolated_visibility(VisibilityPoint p, vec3 weights, vec3 world) {
  VisibilityCorner corner = visibility_corner(world);
  return dot(visibility_shares(corner.fraction), blended_bits(p, weights, corner));
}
float mean_visibility(VisibilityPoint p, vec3 world) { return interpolated_visibility(p, p.open, world); }

/// Mean and absolute difference of two of the four cells around a direction, each chosen with its bilinear weight by u1 and u2.
vec2 two_cells(VisibilityPoint p, vec3 world, vec2 u1, vec2 u2) {
  VisibilityCorner corner = visibility_corner(world);
  vec4 open = blended_bits(p, p.open, corner);
  vec2 f = corner.fraction;
  vec2 of_row1 = u1.x < f.x ? open.yw : open.xz, of_row2 = u2.x < f.x ? open.yw : open.xz;
  float v1 = u1.y < f.y ? of_row1.y : of_row1.x, v2 = u2.y < f.y ? of_row2.y : of_row2.x;
  return vec2(0.5 * (v1 + v2), abs(v1 - v2));
}
