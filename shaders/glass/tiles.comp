// Splits the tiles that show a surface into those with a pane in front of it, and those without. One invocation a tile.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
layout(binding = kUnitPaneHeads) uniform usampler2D t_pane_heads;  // as in kept.glsl
struct Counts {
  uint covered, bare;
};
layout(std430, binding = kBufferTileCounts) buffer TileCounts { Counts b_counts[]; };  // of each band of rows
layout(std430, binding = kBufferCoveredTiles) writeonly buffer CoveredTiles { uint b_covered_tiles[]; };
layout(std430, binding = kBufferBareTiles) writeonly buffer BareTiles { uint b_bare_tiles[]; };
uniform int u_band_rows;  // tiles

void main() {
  ivec2 tile = tile_of(int(linear_id()), 0);
  if (tile.x < 0) return;
  ivec2 last = min(kTile * tile + kTile, u_frame.size.xy) - 1;
  bool covered = false;
  for (int k = 0; k < kTile * kTile && !covered; ++k)
    covered = texelFetch(t_pane_heads, min(kTile * tile + ivec2(k & 7, k >> 3), last), 0).x != 0u;
  int band = tile.y / u_band_rows, tiles_x = (u_frame.size.x + kTile - 1) / kTile;
  uint first = uint(band * u_band_rows * tiles_x), packed_tile = uint(tile.x) | (uint(tile.y) << 16u);
  if (covered) b_covered_tiles[first + atomicAdd(b_counts[band].covered, 1u)] = packed_tile;
  if (!covered) b_bare_tiles[first + atomicAdd(b_counts[band].bare, 1u)] = packed_tile;
}
