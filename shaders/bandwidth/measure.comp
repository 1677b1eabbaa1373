// How much each shaded point deviates from sample to sample, measured from the frames before: the spread of its work items, pooled
// with its neighbours' and with the prediction while there are few. One invocation takes a tile and sums what the
// host needs to turn deviations into sample counts.
layout(local_size_x = 64) in;
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
layout(binding = 18) uniform sampler2D t_mean;    // mean, number of items
layout(binding = 19) uniform sampler2D t_spread;
layout(binding = 21) uniform sampler2D t_pyramid;
layout(binding = 23) uniform usampler2D t_marks;  // shaded, level
layout(binding = 0, r32f) uniform writeonly image2D o_deviation;  // of one sample; 0 where nothing was shaded
layout(std430, binding = 1) writeonly buffer Sums { vec4 b_sums[]; };  // [tile]: sum of deviation * share, sum of share, largest of the first, items
/// Degrees of freedom that the prediction counts as, and the most that one neighbour does.
const float kPredicted = 1.0, kNeighbour = 1.5;

#include "bandwidth/block_share.glsl"

vec2 squares(ivec2 pixel) {  // sum of squares and its degrees of freedom
  return vec2(texelFetch(t_spread, pixel, 0).x, max(texelFetch(t_mean, pixel, 0).w - 1.0, 0.0));
}

float deviation(ivec2 pixel, int level) {
  vec2 sum = squares(pixel);
  for (int k = 0; k < 4; ++k) {
    ivec2 q = pixel + (ivec2(k & 1, k >> 1) * 2 - 1) * (1 << level);
    if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, u_frame.size.xy))) continue;
    vec2 s = squares(q);
    sum += s * (s.y > 0.0 ? min(s.y, kNeighbour) / s.y : 0.0);
  }
  // Items are means of sampling.y samples each.
  float measured = sum.x * float(u_frame.sampling.y), predicted = texelFetch(t_pyramid, pixel / 2, 0).z;
  return sqrt((measured + kPredicted * predicted * predicted) / (sum.y + kPredicted));
}

void main() {
  int id = int(linear_id());
  ivec2 tile = tile_of(id, 0);
  if (tile.x < 0) return;
  ivec2 corner = kTile * tile;
  vec4 sums = vec4(0.0);
  for (int k = 0; k < kTile * kTile; ++k) {
    ivec2 pixel = corner + ivec2(k % kTile, k / kTile);
    if (any(greaterThanEqual(pixel, u_frame.size.xy))) continue;
    uvec4 mark = texelFetch(t_marks, pixel, 0);
    float d = 0.0;
    if (mark.x != 0u) {
      float share = block_share(int(mark.y));
      d = deviation(pixel, int(mark.y));
      sums.xy += vec2(d, 1.0) * share;
      sums.z = max(sums.z, d * share);
      sums.w += texelFetch(t_mean, pixel, 0).w;
    }
    imageStore(o_deviation, pixel, vec4(d));
  }
  b_sums[u_tiles.x + id] = sums;
}
