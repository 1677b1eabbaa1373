// Grid points for passes that skip the sky: 8 x 8 tiles from a list (gbuffer/tiles.comp). A test in each invocation would not be enough, because
// software devices also run branches that no invocation takes. The includer declares 64 invocations a group, and includes frame.glsl before.
#include "shared/bindings.glsl"
#include "shading/linear_id.glsl"
layout(std430, binding = kBufferTiles) readonly buffer Tiles { uint b_tiles[]; };  // x | y << 16, in tiles
uniform ivec4 u_tiles;  // first entry, number, step between entries, whether every other entry comes first
const int kTile = 8;

/// Tile of an invocation if each tile has 2^shift invocations; x < 0 beyond the list. A software device gives each core one contiguous range of groups.
/// If the cost varies strongly over the picture, every other tile comes first: this balances the cores, but neighbours share less cached memory.
ivec2 tile_of(int id, int shift) {
  if (id >= u_tiles.y << shift) return ivec2(-1);
  int k = id >> shift, half_way = (u_tiles.y + 1) / 2;
  if (u_tiles.w != 0) k = k < half_way ? 2 * k : 2 * (k - half_way) + 1;
  uint tile = b_tiles[u_tiles.x + k * u_tiles.z];
  return ivec2(tile & 65535u, tile >> 16u);
}

/// Grid point of this invocation, one each; x < 0 for none.
ivec2 tile_point() {
  int id = int(linear_id());
  ivec2 tile = tile_of(id, 6);
  ivec2 p = kTile * tile + ivec2(id & 7, (id >> 3) & 7);
  return tile.x < 0 || any(greaterThanEqual(p, u_frame.size.xy)) ? ivec2(-1) : p;
}

/// 2 x 2 quad of this invocation, one each; x < 0 for none.
ivec2 tile_quad() {
  int id = int(linear_id());
  ivec2 tile = tile_of(id, 4);
  ivec2 quad = kTile / 2 * tile + ivec2(id & 3, (id >> 2) & 3);
  return tile.x < 0 || any(greaterThanEqual(2 * quad, u_frame.size.xy)) ? ivec2(-1) : quad;
}
