// For each tile of pixels, of the rays of one reflector: the bounding boxes of their origins and directions, and the largest hit distance.
// Triangles farther away are invisible.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "reflections/tiles.glsl"
layout(binding = kUnitRayOrigin) uniform sampler2D t_ray_origin;
layout(binding = kUnitRayDirection) uniform sampler2D t_ray_direction;  // w: reflector + 1
layout(std430, binding = kBufferNearest) readonly buffer Nearest { uvec2 b_nearest[]; };  // as reflections/resolve.comp has them
// [row][column] 4 each: lowest origin, m, how far, m | highest origin | lowest direction | highest direction
layout(std430, binding = kBufferFarTiles) writeonly buffer Tiles { vec4 b_tiles[]; };
uniform int u_reflector;

void main() {
  ivec2 size = textureSize(t_ray_direction, 0), tiles = (size + kFarTile - 1) / kFarTile;
  int tile = int(gl_GlobalInvocationID.x);
  if (tile >= tiles.x * tiles.y) return;
  ivec2 low = kFarTile * ivec2(tile % tiles.x, tile / tiles.x), high = min(low + kFarTile, size);
  vec4 origin_low = vec4(vec3(1e30), 0.0), origin_high = vec4(-1e30), direction_low = vec4(1e30), direction_high = vec4(-1e30);
  for (int y = low.y; y < high.y; ++y) {
    for (int x = low.x; x < high.x; ++x) {
      vec4 direction = texelFetch(t_ray_direction, ivec2(x, y), 0);
      if (int(direction.w) != u_reflector + 1) continue;
      vec3 origin = texelFetch(t_ray_origin, ivec2(x, y), 0).xyz;
      uvec2 nearest = b_nearest[y * size.x + x];
      origin_low = vec4(min(origin_low.xyz, origin), max(origin_low.w, nearest.x != 0u ? uintBitsToFloat(nearest.y) : 1e30));
      origin_high.xyz = max(origin_high.xyz, origin);
      direction_low = min(direction_low, direction);
      direction_high = max(direction_high, direction);
    }
  }
  b_tiles[4 * tile] = origin_low;
  b_tiles[4 * tile + 1] = origin_high;
  b_tiles[4 * tile + 2] = direction_low;
  b_tiles[4 * tile + 3] = direction_high;
}
