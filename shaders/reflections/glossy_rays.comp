// The mirrored rays of glossy opaque points, one for each block of them: from the point into the mean direction of its lobe.
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
#include "octree/visibility.glsl"
layout(binding = kImageRayOrigin, rgba32f) uniform writeonly image2D o_origin;        // m; w: depth, 0 for no ray
layout(binding = kImageRayDirection, rgba32f) uniform writeonly image2D o_direction;  // unit; w: material + 1
layout(binding = kImageLobeWidth, r16f) uniform writeonly image2D o_width;            // rad: half of the lobe lies within
uniform int u_divisor;

/// The k-th candidate point of a block. The middle comes first, so that a narrow strip does not flicker.
ivec2 point_of_block(ivec2 block, int k) {
  ivec2 offset = k == 0 ? ivec2(u_divisor / 2) : ivec2(k & 1, k >> 1) * (u_divisor - 1) / (u_divisor > 2 ? 2 : 1);
  return min(block * u_divisor + offset, u_frame.size.xy - 1);
}

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
    VisibilityPoint start = load_visibility(at, p.position, world_from_environment(p.n));
    origin = vec4(start.origin, texelFetch(t_depth, at, 0).x);
    direction = vec4(normalize(to_world(p, lobe.direction)), float(p.material + 1));
    width = lobe.half_angle;
  }
  if (origin.w == 0.0) return;
  imageStore(o_origin, block, origin);
  imageStore(o_direction, block, direction);
  imageStore(o_width, block, vec4(width));
}
