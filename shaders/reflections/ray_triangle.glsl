// Intersection of a pixel's mirrored ray with a triangle of the scene.
#include "shared/bindings.glsl"
layout(binding = kUnitIndices) uniform usamplerBuffer t_indices;
layout(binding = kUnitVertices) uniform samplerBuffer t_vertices;
layout(binding = kUnitRayOrigin) uniform sampler2D t_ray_origin;
layout(binding = kUnitRayDirection) uniform sampler2D t_ray_direction;  // w: reflector + 1

/// Tolerance in barycentrics, so that no ray passes between two adjacent triangles by rounding.
const float kSeam = 1e-5;
/// Hits nearer than this are ignored: they belong to parts that touch the reflector, m.
const float kNear_m = 1e-4;

struct SceneTriangle {
  vec3 a, e1, e2;  // m: a corner, the edges from it
};

SceneTriangle fetch_triangle(int triangle) {
  vec3 a = texelFetch(t_vertices, 4 * int(texelFetch(t_indices, 3 * triangle).x)).xyz;
  vec3 b = texelFetch(t_vertices, 4 * int(texelFetch(t_indices, 3 * triangle + 1).x)).xyz;
  vec3 c = texelFetch(t_vertices, 4 * int(texelFetch(t_indices, 3 * triangle + 2).x)).xyz;
  return SceneTriangle(a, b - a, c - a);
}

/// Metres along the ray; negative where it misses. Source: Moller and Trumbore 1997.
float distance_to(vec3 origin, vec3 direction, SceneTriangle t) {
  vec3 q = cross(direction, t.e2), s = origin - t.a, r = cross(s, t.e1);
  float determinant = dot(t.e1, q);
  if (abs(determinant) < 1e-30) return -1.0;
  vec3 hit = vec3(dot(s, q), dot(direction, r), dot(t.e2, r)) * (1.0 / determinant);
  return hit.x < -kSeam || hit.y < -kSeam || hit.x + hit.y > 1.0 + kSeam || hit.z < kNear_m ? -1.0 : hit.z;
}
