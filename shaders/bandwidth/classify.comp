// Lists the quads with a visible surface, those with measured and with analytic materials separately, so that neighbouring invocations run the
// same code. The first visible point of a quad represents it; which point is tried first alternates from quad to quad.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/gbuffer.glsl"
#include "shared/material_table.glsl"
#include "shared/bandwidth.glsl"
#include "bandwidth/broad.glsl"
layout(binding = kUnitSurface) uniform usampler2D t_surface;
layout(binding = kUnitDepth) uniform sampler2D t_depth;
struct List {
  uint items, points, groups_x, groups_y, groups_z, samples, visible, overflow;
};
layout(std430, binding = kBufferCounters) buffer Counters { List b_lists[2]; };
layout(std430, binding = kBufferMeasuredPixels) writeonly buffer MeasuredPixels { uint b_measured[]; };
layout(std430, binding = kBufferAnalyticPixels) writeonly buffer AnalyticPixels { uint b_analytic[]; };
layout(binding = kImageEnergy, rgba32f) uniform writeonly image2D o_energy;

void main() {
  ivec2 quads = (u_frame.size.xy + 1) / 2;
  int id = int(linear_id());
#if FIRST_ONLY
  const int kStep = 2;  // an invocation handles a tile
  ivec2 tile = tile_of(id, 0);
  ivec2 corner = kTile / 2 * tile;
#else
  const int kStep = 1;
  ivec2 tile = tile_of(id, 2);
  ivec2 corner = kTile / 2 * tile + 2 * ivec2(id & 1, (id >> 1) & 1);
#endif
  if (tile.x < 0) return;
  uint pixels[4];
  uint measured_count = 0u, analytic_count = 0u, first_material = 0xffffffffu;
  for (int k = 0; k < 4; ++k) {
    ivec2 quad = corner + kStep * ivec2(k & 1, k >> 1);
    pixels[k] = 0xffffffffu;
    if (any(greaterThanEqual(quad, quads))) continue;
    ivec2 pixel = ivec2(-1);
    for (int j = 0; j < 4; ++j) {
      int i = (j + quad.x + 2 * quad.y) & 3;
      ivec2 q = min(2 * quad + ivec2(i & 1, i >> 1), u_frame.size.xy - 1);
      if (pixel.x < 0 && texelFetch(t_depth, q, 0).x > 0.0) pixel = q;
    }
    uvec4 surface = texelFetch(t_surface, max(pixel, ivec2(0)), 0);
    uint material = surface.z >> 16u, flags = material_words(int(material), 6).x;
    bool measured = (flags & kMaterialMeasured) != 0u;
    // In a block of one broad material one quad in four is enough, because bandwidth.comp pools neighbours. Narrow lobes need one quad in two:
    // one in four misses mirrored suns (10 instead of 3.9 % error for a car's door), and all four improve nothing (docs/tried.md).
    // FIRST_ONLY (several points a pixel): only the first quad of every other block is predicted.
    if (k == 0 && pixel.x >= 0) first_material = material;
    if (k > 0 && material == first_material && (k < 3 || (FIRST_ONLY == 0 && is_broad(surface, flags, measured)))) pixel.x = -1;
    if (pixel.x < 0) {
      imageStore(o_energy, quad, vec4(0.0));
      continue;
    }
    measured_count += measured ? 1u : 0u;
    analytic_count += measured ? 0u : 1u;
    pixels[k] = uint(pixel.x) | (uint(pixel.y) << 16u) | (measured ? 0u : 0x80000000u);
  }
  uint next_measured = 0u, next_analytic = 0u;
  if (measured_count > 0u) next_measured = atomicAdd(b_lists[0].items, measured_count);
  if (analytic_count > 0u) next_analytic = atomicAdd(b_lists[1].items, analytic_count);
  for (int k = 0; k < 4; ++k) {
    if (pixels[k] == 0xffffffffu) continue;
    if ((pixels[k] & 0x80000000u) == 0u)
      b_measured[2u * next_measured++] = pixels[k];
    else
      b_analytic[2u * next_analytic++] = pixels[k] & 0x7fffffffu;
  }
}
