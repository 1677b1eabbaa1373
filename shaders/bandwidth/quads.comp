// With several points a pixel: lists the plain quads of 2 x 2 points, and the other quads that show a surface. In a plain quad the three
// points of the finest level lie on the same surface as the coarser ones around and are filled from them. compose.comp then computes one value
// for the quad without comparing surfaces again.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
layout(binding = kUnitMarks) uniform usampler2D t_marks;
layout(std430, binding = kBufferQuadCounts) buffer Counts { uint b_plain_count, b_mixed_count; };
layout(std430, binding = kBufferPlainQuads) writeonly buffer PlainQuads { uint b_plain[]; };
layout(std430, binding = kBufferMixedQuads) writeonly buffer MixedQuads { uint b_mixed[]; };

void main() {
  ivec2 tile = tile_of(int(linear_id()), 2);
  if (tile.x < 0) return;
  ivec2 corner = kTile * tile + 4 * ivec2(linear_id() & 1u, (linear_id() >> 1u) & 1u);
  uint plain = 0u, mixed = 0u;  // bits
  for (int k = 0; k < 4; ++k) {
    ivec2 first = corner + 2 * ivec2(k & 1, k >> 1);
    if (any(greaterThanEqual(first, u_frame.size.xy))) continue;  // several points a pixel make whole quads
    uvec4 near = texelFetch(t_marks, first, 0), right = texelFetch(t_marks, first + ivec2(1, 0), 0);
    uvec4 below = texelFetch(t_marks, first + ivec2(0, 1), 0), far = texelFetch(t_marks, first + 1, 0);
    bool visible = (near.w | right.w | below.w | far.w) != 0u;
    bool is_plain = far.w == 3u && (right.x | below.x | far.x) == 0u && min(near.w, min(right.w, below.w)) != 0u;
    plain |= is_plain ? 1u << k : 0u;
    mixed |= visible && !is_plain ? 1u << k : 0u;
  }
  uint next_plain = plain != 0u ? atomicAdd(b_plain_count, bitCount(plain)) : 0u;
  uint next_mixed = mixed != 0u ? atomicAdd(b_mixed_count, bitCount(mixed)) : 0u;
  for (int k = 0; k < 4; ++k) {
    ivec2 first = corner + 2 * ivec2(k & 1, k >> 1);
    uint packed_point = uint(first.x) | (uint(first.y) << 16u);
    if (((plain >> k) & 1u) != 0u) b_plain[next_plain++] = packed_point;
    if (((mixed >> k) & 1u) != 0u) b_mixed[next_mixed++] = packed_point;
  }
}
