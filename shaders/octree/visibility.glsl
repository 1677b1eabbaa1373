// Visibility of a shading point by rays through the octree, which contains no panes. Replaces shading/visibility.glsl.
#include "shared/bindings.glsl"
#include "octree/tables.glsl"

/// A ray starts this far above its surface, in cells: outside the slab of its own cell's plane, including the plane's error.
const float kOctreeLift = 0.25;
/// Solid cells are ignored up to this distance, in cells: around a crease or a rim they contain the surface itself.
const float kOctreeOwnCells = 1.8;

struct VisibilityPoint {
  vec3 origin;  // m, world
  float own_m;  // up to this distance solid cells may contain the surface itself
};

VisibilityPoint visibility_point(vec3 position, vec3 normal) {
  float cell_m = octree_cell_at(octree_frame(), position) / u_octree.w;
  return VisibilityPoint(position + normal * (kOctreeLift * cell_m), kOctreeOwnCells * cell_m);
}

#ifdef REFLECTED
/// For reflected points, which may lie on an octree cell instead of a triangle.
VisibilityPoint load_visibility(ivec2 pixel, vec3 position, vec3 normal) { return visibility_point(position, normal); }
#else
layout(binding = kUnitTriangle) uniform usampler2D t_triangle;
layout(binding = kUnitIndices) uniform usamplerBuffer t_indices;
layout(binding = kUnitVertices) uniform samplerBuffer t_vertices;

/// `normal` is the shading normal; the ray's origin is moved along the geometric normal.
VisibilityPoint load_visibility(ivec2 pixel, vec3 position, vec3 normal) {
  int triangle = max(int(texelFetch(t_triangle, pixel, 0).x), 1) - 1;
  ivec3 v = ivec3(texelFetch(t_indices, 3 * triangle).x, texelFetch(t_indices, 3 * triangle + 1).x,
                  texelFetch(t_indices, 3 * triangle + 2).x);
  vec3 p0 = texelFetch(t_vertices, 4 * v.x).xyz;
  vec3 n = cross(texelFetch(t_vertices, 4 * v.y).xyz - p0, texelFetch(t_vertices, 4 * v.z).xyz - p0);
  n = dot(n, n) > 1e-24 ? normalize(n) : normal;
  return visibility_point(position, dot(n, normal) < 0.0 ? -n : n);
}
#endif

/// Distance to what blocks the direction, or -1.
float blocked_at(VisibilityPoint p, vec3 world, float t_max) {
  OctreeHit hit = octree_trace(octree_frame(), OctreeRay(p.origin, world, 0.0, t_max, p.own_m, 0.0, 0.0));
  return hit.node >= 0 ? hit.t : -1.0;
}

/// Visibility in a direction, 0 or 1; same interface as shading/visibility.glsl.
float mean_visibility(VisibilityPoint p, vec3 world) { return blocked_at(p, world, 1e30) < 0.0 ? 1.0 : 0.0; }
