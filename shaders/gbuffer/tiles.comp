// Lists the tiles of 8 x 8 grid points that show a surface, and the tiles that show sky; a tile may be in both lists. One invocation a tile.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shading/linear_id.glsl"
layout(binding = kUnitTriangle) uniform usampler2D t_triangle;
struct Counts {
  uint surface, sky;
};
layout(std430, binding = kBufferTileCounts) buffer TileCounts { Counts b_counts[]; };  // of each band of rows
layout(std430, binding = kBufferSurfaceTiles) writeonly buffer SurfaceTiles { uint b_surface_tiles[]; };
layout(std430, binding = kBufferSkyTiles) writeonly buffer SkyTiles { uint b_sky_tiles[]; };
uniform int u_band_rows;  // tiles
const int kTile = 8;

void main() {
  ivec2 tiles = (u_frame.size.xy + kTile - 1) / kTile;
  int id = int(linear_id());
  if (id >= tiles.x * tiles.y) return;
  ivec2 tile = ivec2(id % tiles.x, id / tiles.x);
  ivec2 last = min(kTile * tile + kTile, u_frame.size.xy) - 1;
  bool surface = false, sky = false;
  for (int k = 0; k < kTile * kTile; ++k) {
    // Beyond the border the last row and column are repeated.
    uint triangle = texelFetch(t_triangle, min(kTile * tile + ivec2(k & 7, k >> 3), last), 0).x;
    surface = surface || triangle != 0u;
    sky = sky || triangle == 0u;
    if (surface && sky) break;
  }
  int band = tile.y / u_band_rows;
  uint packed_tile = uint(tile.x) | (uint(tile.y) << 16u);
  uint first = uint(band * u_band_rows * tiles.x);
  if (surface) b_surface_tiles[first + atomicAdd(b_counts[band].surface, 1u)] = packed_tile;
  if (sky) b_sky_tiles[first + atomicAdd(b_counts[band].sky, 1u)] = packed_tile;
}
