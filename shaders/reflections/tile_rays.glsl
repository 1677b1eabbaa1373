// The rays of one reflector by tiles of pixels, as reflections/far.comp writes them.
#include "shared/bindings.glsl"
layout(binding = kUnitFarTiles) uniform samplerBuffer t_tiles;

/// Largest hit distance in the tile, m.
float tile_far(int tile) { return texelFetch(t_tiles, 4 * tile).w; }

/// Whether o + t d lies in the box for some 0 <= t <= far and some o and d within their bounds, for each axis separately: t >= 0 with
/// t d_high >= low - o_high and t d_low <= high - o_low.
bool tile_may_meet(int tile, vec3 low, vec3 high) {
  vec4 o_low = texelFetch(t_tiles, 4 * tile);
  vec3 o_high = texelFetch(t_tiles, 4 * tile + 1).xyz, d_low = texelFetch(t_tiles, 4 * tile + 2).xyz, d_high = texelFetch(t_tiles, 4 * tile + 3).xyz;
  vec3 a = (low - o_high) / mix(d_high, vec3(1e-20), equal(d_high, vec3(0.0))), b = (high - o_low.xyz) / mix(d_low, vec3(-1e-20), equal(d_low, vec3(0.0)));
  bvec3 up = greaterThanEqual(d_high, vec3(0.0)), down = lessThanEqual(d_low, vec3(0.0));
  vec3 from = max(mix(vec3(0.0), a, up), mix(vec3(0.0), b, down)), to = min(mix(a, vec3(1e30), up), mix(b, vec3(1e30), down));
  float enters = max(max(from.x, from.y), from.z), leaves = min(min(to.x, to.y), to.z);
  return enters <= leaves && enters <= o_low.w;
}

/// Tolerance for rounding, relative to the distance from the world's origin.
const float kBoxRounding = 1e-6;
bool tile_may_meet_rounded(int tile, vec3 low, vec3 high) {
  vec3 slack = kBoxRounding * max(abs(low), abs(high));
  return tile_may_meet(tile, low - slack, high + slack);
}
