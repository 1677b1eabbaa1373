// The mirrored rays of glossy opaque points, one for each block of them: from the point into the mean direction of its lobe, or (EXACT, from the
// second frame at rest on) into another direction of it in every frame.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/constants.glsl"
#include "shared/latlong.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/gbuffer.glsl"
#include "shared/material_table.glsl"
#include "shared/luminance.glsl"
#include "shared/analytic.glsl"
#include "shared/merl.glsl"
#include "shading/point.glsl"
#include "shading/lobes.glsl"
#include "reflections/glossy.glsl"
#if EXACT
#include "shading/random.glsl"
layout(binding = kUnitTriangle) uniform usampler2D t_triangle;
layout(binding = kUnitIndices) uniform usamplerBuffer t_indices;
layout(binding = kUnitVertices) uniform samplerBuffer t_vertices;
uniform int u_frame_at_rest;
#else
#include "octree/visibility.glsl"
#endif
layout(binding = kImageRayOrigin, rgba32f) uniform writeonly image2D o_origin;        // m; w: depth, 0 for no ray
layout(binding = kImageRayDirection, rgba32f) uniform writeonly image2D o_direction;  // unit; w: material + 1
layout(binding = kImageLobeWidth, r16f) uniform writeonly image2D o_width;            // rad: half of the lobe lies within
uniform int u_divisor;

/// The k-th candidate point of a block. The middle comes first, so that a narrow strip does not flicker.
ivec2 point_of_block(ivec2 block, int k) {
  ivec2 offset = k == 0 ? ivec2(u_divisor / 2) : ivec2(k & 1, k >> 1) * (u_divisor - 1) / (u_divisor > 2 ? 2 : 1);
  return min(block * u_divisor + offset, u_frame.size.xy - 1);
}

#if EXACT
/// A direction below the triangle that the point lies on is turned up to its plane: the interpolated normal has it there.
vec3 above_facet(ivec2 at, vec3 direction, vec3 normal) {
  int first = 3 * (int(texelFetch(t_triangle, at, 0).x) - 1);
  vec3 p0 = texelFetch(t_vertices, 4 * int(texelFetch(t_indices, first).x)).xyz;
  vec3 n = cross(texelFetch(t_vertices, 4 * int(texelFetch(t_indices, first + 1).x)).xyz - p0,
                 texelFetch(t_vertices, 4 * int(texelFetch(t_indices, first + 2).x)).xyz - p0);
  if (dot(n, n) < 1e-24) return direction;
  n = dot(n, normal) < 0.0 ? -normalize(n) : normalize(n);
  return normalize(direction + max(1e-3 - dot(direction, n), 0.0) * n);
}
#endif

void main() {
  int side = kTile / u_divisor, id = int(linear_id()), shift = 2 * findMSB(side);
  ivec2 tile = tile_of(id, shift);
  ivec2 block = side * tile + ivec2(id & (side - 1), (id >> findMSB(side)) & (side - 1));
  if (tile.x < 0 || any(greaterThanEqual(block, imageSize(o_origin)))) return;
  vec4 origin = vec4(0.0), direction = vec4(0.0);
  float width = 0.0;
  for (int k = 0; k < (u_divisor > 1 ? 4 : 1) && origin.w == 0.0; ++k) {
    ivec2 at = point_of_block(block, k);
    if (!(texelFetch(t_depth, at, 0).x > 0.0)) continue;
    Point p = load_point(at);
    MirrorLobe lobe = mirror_lobe(p, int(texelFetch(t_triangle, at, 0).x) - 1);
    if (!mirrors(lobe)) continue;
#if EXACT
    origin = vec4(p.position, texelFetch(t_depth, at, 0).x);
    vec3 along = u_frame_at_rest > 0 ? sample_mirror(p, lobe, numbers_at_rest(at, u_frame_at_rest)) : lobe.direction;
    direction = vec4(above_facet(at, normalize(to_world(p, along)), world_from_environment(p.n)), float(p.material + 1));
#else
    VisibilityPoint start = load_visibility(at, p.position, world_from_environment(p.n));
    origin = vec4(start.origin, texelFetch(t_depth, at, 0).x);
    direction = vec4(normalize(to_world(p, lobe.direction)), float(p.material + 1));
#endif
    width = lobe.half_angle;
  }
  if (origin.w == 0.0) return;
  imageStore(o_origin, block, origin);
  imageStore(o_direction, block, direction);
  imageStore(o_width, block, vec4(width));
}
