// Finds, among the triangles offered for a pixel, the nearest that its mirrored ray hits. A technique offers a triangle with a conservative region on
// screen, and every tile of the region adds it to its list. reflections/resolve.comp then intersects each pixel's ray with its tile's list, so
// no triangle is shown where the ray misses it, and edges are exact.
#include "shared/bindings.glsl"
#include "reflections/ray_triangle.glsl"
#include "reflections/tiles.glsl"
#include "reflections/ghost.glsl"
#include "reflections/tile_rays.glsl"
// counters: nodes, with the heads before them; offers; large ones | [tile] x: first node of its list | [node] offer, next or 0
layout(std430, binding = kBufferOfferLists) coherent buffer Lists { uint b_nodes, b_offers, b_large, b_unused; uvec2 b_lists[]; };
// 5 an offer: corner, m, triangle + 1 and effort | edge, m, 0 | edge, m, reflector | two corners on screen, px | the third, margin, px
layout(std430, binding = kBufferOffers) coherent buffer Offers { uvec4 b_offer[]; };
layout(std430, binding = kBufferLargeOffers) coherent buffer Large { uint b_large_offers[]; };
uniform uvec2 u_capacity;  // of lists; of offers, which the large ones share
/// Largest number of tiles whose lists one invocation extends; a larger triangle gets a group of its own (reflections/large.comp).
#ifndef OWN_TILES
#define OWN_TILES 8
#endif
/// Error of the end points of edges, px.
const float kEndError_px = 0.05;
/// Added to a margin when only the bounding box of the corners is known.
const float kBoxOnly = 1e6;

uint offered(int triangle, int effort) { return uint(triangle + 1) << kEffortBits | uint(clamp(effort, 0, 127)); }

/// Region on screen where a triangle may be seen: the triangle of its three corners, extended by the margin.
struct Box {
  ivec2 low, high;  // tiles, both within
  vec3 x, y, rest;  // of the three edges: x px.x + y px.y + rest is negative beyond the margin
};

Box make_box(vec2 p, vec2 q, vec2 r, float margin_px) {
  Box box;
  bool box_only = margin_px >= kBoxOnly;
  float around = box_only ? margin_px - kBoxOnly : margin_px;
  vec2 size = vec2(textureSize(t_ray_direction, 0));
  // Of the pixels whose centres are inside.
  vec2 low = ceil(clamp(min(min(p, q), r) - around - 0.5, vec2(0.0), size)), high = floor(clamp(max(max(p, q), r) + around - 0.5, vec2(-1.0), size - 1.0));
  box.low = ivec2(low) / kTile;
  box.high = any(lessThan(high, low)) ? box.low - 1 : ivec2(high) / kTile;
  vec2 e = q - p, f = r - q, g = p - r;
  float orientation = e.x * g.y - e.y * g.x > 0.0 ? -1.0 : 1.0;
  box.x = -orientation * vec3(e.y, f.y, g.y);
  box.y = orientation * vec3(e.x, f.x, g.x);
  box.rest = orientation * vec3(e.y * p.x - e.x * p.y, f.y * q.x - f.x * q.y, g.y * r.x - g.x * r.y) + around * vec3(length(e), length(f), length(g));
  if (box_only) {
    box.x = box.y = vec3(0.0);
    box.rest = vec3(1.0);
  }
  return box;
}

/// Adds an offer to the lists of the box's tiles that its edges do not exclude and that no nearer hit covers.
void list_offer(Box box, uint offer, float nearest_m, SceneTriangle triangle, ivec2 first, ivec2 stride) {
  vec3 low = triangle.a + min(min(triangle.e1, triangle.e2), vec3(0.0)), high = triangle.a + max(max(triangle.e1, triangle.e2), vec3(0.0));
  ivec2 size = textureSize(t_ray_direction, 0);
  int columns = tile_columns(size), far_columns = (size.x + kFarTile - 1) / kFarTile;
  // From a tile's middle to the middles of its pixels.
  vec3 half_way = 0.5 * float(kTile - 1) * (abs(box.x) + abs(box.y)) + box.rest;
  for (int y = box.low.y + first.y; y <= box.high.y; y += stride.y) {
    for (int x = box.low.x + first.x; x <= box.high.x; x += stride.x) {
      vec2 middle = (vec2(x, y) + 0.5) * float(kTile);
      vec3 inside = half_way + box.x * middle.x + box.y * middle.y;
      if (min(min(inside.x, inside.y), inside.z) < 0.0) continue;
      ivec2 at = ivec2(x, y) * kTile / kFarTile;
#if LARGE
      if (!tile_may_meet_rounded(at.y * far_columns + at.x, low, high)) continue;
#else
      if (tile_far(at.y * far_columns + at.x) < nearest_m) continue;
#endif
      uint node = atomicAdd(b_nodes, 1u);
      if (node < u_capacity.x) b_lists[node] = uvec2(offer, atomicExchange(b_lists[y * columns + x].x, node));
    }
  }
}

/// Small triangles are added to the lists at once, large ones are collected for reflections/large.comp. `nearest_m`: lower bound of the distance
/// along a mirrored ray.
void offer_triangle(vec2 p, vec2 q, vec2 r, float margin_px, float nearest_m, uint own, int reflector) {
  Box box = make_box(p, q, r, margin_px);
  ivec2 extent = box.high - box.low + 1;
  if (extent.x <= 0 || extent.y <= 0) return;
  uint offer = atomicAdd(b_offers, 1u);
  if (offer >= u_capacity.y) return;
  SceneTriangle t = fetch_triangle(int(own >> kEffortBits) - 1);
  b_offer[5u * offer] = uvec4(floatBitsToUint(t.a), own);
  b_offer[5u * offer + 1u] = floatBitsToUint(vec4(t.e1, 0.0));
  b_offer[5u * offer + 2u] = uvec4(floatBitsToUint(t.e2), uint(reflector));
  if (extent.x * extent.y > OWN_TILES) {
    b_offer[5u * offer + 3u] = floatBitsToUint(vec4(p, q));
    b_offer[5u * offer + 4u] = floatBitsToUint(vec4(r, margin_px, 0.0));
    b_large_offers[atomicAdd(b_large, 1u)] = offer;
    return;
  }
  list_offer(box, offer, nearest_m, t, ivec2(0), ivec2(1));
}
