// Which boxes some pixel's mirrored ray may meet before what has been found for it, by tiles of pixels: a group for each box.
layout(local_size_x = 8) in;
#include "reflections/tiles.glsl"
layout(binding = 50) uniform sampler2D t_ray_direction;
layout(binding = 47) uniform samplerBuffer t_tiles;  // as reflections/far.comp writes them
layout(binding = 55) uniform samplerBuffer t_boxes;  // 3 each: lower corner, m | upper corner, m | two corners on screen, px
layout(std430, binding = 3) writeonly buffer Visible { uint b_visible[]; };
uniform int u_count;
uniform int u_per_row;  // of groups

/// Of what is just met by rounding, m for each m from the world's origin.
const float kRounding = 1e-6;

/// Whether o + t d lies within the box for a 0 <= t <= far, an o and a d between their bounds, of each axis apart: t >= 0 with
/// t d_high >= low - o_high and t d_low <= high - o_low.
bool may_be_met(int tile, vec3 low, vec3 high) {
  vec4 o_low = texelFetch(t_tiles, 4 * tile);
  vec3 o_high = texelFetch(t_tiles, 4 * tile + 1).xyz, d_low = texelFetch(t_tiles, 4 * tile + 2).xyz, d_high = texelFetch(t_tiles, 4 * tile + 3).xyz;
  vec3 a = (low - o_high) / mix(d_high, vec3(1e-20), equal(d_high, vec3(0.0))), b = (high - o_low.xyz) / mix(d_low, vec3(-1e-20), equal(d_low, vec3(0.0)));
  bvec3 up = greaterThanEqual(d_high, vec3(0.0)), down = lessThanEqual(d_low, vec3(0.0));
  vec3 from = max(mix(vec3(0.0), a, up), mix(vec3(0.0), b, down)), to = min(mix(a, vec3(1e30), up), mix(b, vec3(1e30), down));
  float enters = max(max(from.x, from.y), from.z), leaves = min(min(to.x, to.y), to.z);
  return enters <= leaves && enters <= o_low.w;
}

void main() {
  int i = int(gl_WorkGroupID.x) + u_per_row * int(gl_WorkGroupID.y);
  if (i >= u_count) return;
  vec3 low = texelFetch(t_boxes, 3 * i).xyz, high = texelFetch(t_boxes, 3 * i + 1).xyz;
  vec4 rectangle = texelFetch(t_boxes, 3 * i + 2);
  vec3 slack = kRounding * max(abs(low), abs(high));
  ivec2 size = textureSize(t_ray_direction, 0), tiles = (size + kFarTile - 1) / kFarTile;
  if (any(lessThan(rectangle.zw, max(rectangle.xy, vec2(0.0)))) || any(greaterThan(rectangle.xy, vec2(size)))) return;
  ivec2 from = ivec2(max(rectangle.xy, vec2(0.0))) / kFarTile, to = ivec2(min(rectangle.zw, vec2(size - 1))) / kFarTile;
  for (int y = from.y; y <= to.y; ++y) {
    for (int x = from.x + int(gl_LocalInvocationID.x); x <= to.x; x += 8) {
      if (may_be_met(y * tiles.x + x, low - slack, high + slack)) {
        b_visible[i] = 1u;
        return;
      }
    }
  }
}
