// Lists the tiles that show a material that was replaced since the frame before. One invocation for each tile that shows a surface.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/material_table.glsl"
layout(binding = kUnitSurface) uniform usampler2D t_surface;
layout(binding = kUnitDepth) uniform sampler2D t_depth;
layout(std430, binding = kBufferTileCounts) buffer TileCounts { uint b_counts[]; };  // of each band of rows, every other word
layout(std430, binding = kBufferReplacedMaterialTiles) writeonly buffer ReplacedMaterialTiles { uint b_replaced_material_tiles[]; };
uniform int u_band_rows;  // tiles

void main() {
  ivec2 tile = tile_of(int(linear_id()), 0);
  if (tile.x < 0) return;
  ivec2 last = min(kTile * tile + kTile, u_frame.size.xy) - 1;
  bool found = false;
  for (int k = 0; k < kTile * kTile && !found; ++k) {
    ivec2 pixel = min(kTile * tile + ivec2(k & 7, k >> 3), last);
    uint flags = material_words(int(texelFetch(t_surface, pixel, 0).z >> 16u), 6).x;
    found = (flags & kMaterialReplaced) != 0u && texelFetch(t_depth, pixel, 0).x > 0.0;
  }
  if (!found) return;
  int band = tile.y / u_band_rows, tiles_x = (u_frame.size.x + kTile - 1) / kTile;
  b_replaced_material_tiles[uint(band * u_band_rows * tiles_x) + atomicAdd(b_counts[2 * band], 1u)] = uint(tile.x) | (uint(tile.y) << 16u);
}
