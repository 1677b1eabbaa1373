// Lists the tiles of 8 x 8 pixels that show a reflector or, with RAYS, that have mirrored rays, as reflectors may be hidden. One invocation a tile.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#if RAYS
#define REFLECTED 1
#endif
#include "shared/frame.glsl"
#include "shading/linear_id.glsl"
layout(binding = kUnitPane) uniform usampler2D t_pane;
layout(std430, binding = kBufferTileCounts) buffer TileCounts { uint b_count; };
layout(std430, binding = kBufferPaneTiles) writeonly buffer Tiles { uint b_tiles[]; };  // as in shared/tiles.glsl
const int kTile = 8;

bool shows(ivec2 pixel) {
#if RAYS
  return texelFetch(t_ray_direction, pixel, 0).w != 0.0;
#else
  return texelFetch(t_pane, pixel, 0).x != 0u;
#endif
}

void main() {
  ivec2 tiles = (u_frame.size.xy + kTile - 1) / kTile;
  int id = int(linear_id());
  if (id >= tiles.x * tiles.y) return;
  ivec2 tile = ivec2(id % tiles.x, id / tiles.x), last = min(kTile * tile + kTile, u_frame.size.xy) - 1;
  bool shown = false;
  int k = 0;
  do {
    // Beyond the border the last row and column are repeated.
    shown = shows(min(kTile * tile + ivec2(k & 7, k >> 3), last));
    ++k;
  } while (k < kTile * kTile && !shown);
  if (shown) b_tiles[atomicAdd(b_count, 1u)] = uint(tile.x) | (uint(tile.y) << 16u);
}
