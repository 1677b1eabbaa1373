// Finds the boxes that a pixel's mirrored ray may hit before its present hit, by tiles of pixels. One group for each box.
layout(local_size_x = 8) in;
#include "shared/bindings.glsl"
#include "reflections/tiles.glsl"
#include "reflections/tile_rays.glsl"
layout(binding = kUnitRayDirection) uniform sampler2D t_ray_direction;
layout(binding = kUnitBoxes) uniform samplerBuffer t_boxes;  // 3 each: lower corner, m | upper corner, m | two corners on screen, px
layout(std430, binding = kBufferVisibleBoxes) writeonly buffer Visible { uint b_visible[]; };
uniform int u_count;
uniform int u_per_row;  // of groups

void main() {
  int i = int(gl_WorkGroupID.x) + u_per_row * int(gl_WorkGroupID.y);
  if (i >= u_count) return;
  vec3 low = texelFetch(t_boxes, 3 * i).xyz, high = texelFetch(t_boxes, 3 * i + 1).xyz;
  vec4 rectangle = texelFetch(t_boxes, 3 * i + 2);
  ivec2 size = textureSize(t_ray_direction, 0), tiles = (size + kFarTile - 1) / kFarTile;
  if (any(lessThan(rectangle.zw, max(rectangle.xy, vec2(0.0)))) || any(greaterThan(rectangle.xy, vec2(size)))) return;
  ivec2 from = ivec2(max(rectangle.xy, vec2(0.0))) / kFarTile, to = ivec2(min(rectangle.zw, vec2(size - 1))) / kFarTile;
  for (int y = from.y; y <= to.y; ++y) {
    for (int x = from.x + int(gl_LocalInvocationID.x); x <= to.x; x += 8) {
      if (tile_may_meet_rounded(y * tiles.x + x, low, high)) {
        b_visible[i] = 1u;
        return;
      }
    }
  }
}
