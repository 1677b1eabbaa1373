// Lists the tiles that may show an opaque surface glossy enough to be traced (conservative). One invocation for each tile that shows a surface.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/gbuffer.glsl"
#include "shared/material_table.glsl"
#include "reflections/glossy_parts.glsl"
layout(binding = kUnitTriangle) uniform usampler2D t_triangle;
layout(binding = kUnitSurface) uniform usampler2D t_surface;
layout(binding = kUnitDepth) uniform sampler2D t_depth;
layout(binding = kUnitLobes) uniform samplerBuffer t_lobes;  // as in shading/lobes.glsl
layout(std430, binding = kBufferTileCounts) buffer TileCounts { uint b_counts[]; };  // of each band of rows, every other word
layout(std430, binding = kBufferGlossyTiles) writeonly buffer GlossyTiles { uint b_glossy_tiles[]; };
uniform int u_band_rows;  // tiles

/// Texels of a table in t_lobes.
const int kLobeTexels = 4 * 64;

bool may_mirror(ivec2 pixel) {
  uint word = texelFetch(t_surface, pixel, 0).z;
  uvec4 words = material_words(int(word >> 16u), 6);
  float widest = widest_roughness(int(texelFetch(t_triangle, pixel, 0).x) - 1) + 0.5 / 255.0;
#if MEASURED
  if ((words.x & kMaterialMeasured) != 0u) return texelFetch(t_lobes, int(words.y) * kLobeTexels).w <= widest;
#endif
  vec4 coat = material_floats(int(word >> 16u), 3);
  return (coat.x > 0.0 && coat.y <= widest) || unpack_roughness(word) <= widest;
}

void main() {
  ivec2 tile = tile_of(int(linear_id()), 0);
  if (tile.x < 0) return;
  ivec2 last = min(kTile * tile + kTile, u_frame.size.xy) - 1;
  bool found = false;
  for (int k = 0; k < kTile * kTile && !found; ++k) {
    ivec2 pixel = min(kTile * tile + ivec2(k & 7, k >> 3), last);
    found = texelFetch(t_depth, pixel, 0).x > 0.0 && may_mirror(pixel);
  }
  if (!found) return;
  int band = tile.y / u_band_rows, tiles_x = (u_frame.size.x + kTile - 1) / kTile;
  b_glossy_tiles[uint(band * u_band_rows * tiles_x) + atomicAdd(b_counts[2 * band], 1u)] = uint(tile.x) | (uint(tile.y) << 16u);
}
