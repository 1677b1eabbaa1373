// Statistics of earlier frames. For each shaded point, the standard deviation of its samples: from the spread of its work items,
// pooled with its neighbours' and with the prediction while there are few. For each tile, level and class, the difference between interpolated
// values and the points' own means. One invocation handles a tile, and sums what the host needs to compute sample counts from deviations.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/interpolation.glsl"
layout(binding = kUnitMean) uniform sampler2D t_mean;  // mean, number of items
layout(binding = kUnitSpread) uniform sampler2D t_spread;
layout(binding = kUnitPyramid) uniform sampler2D t_pyramid;
layout(binding = kUnitMarks) uniform usampler2D t_marks;  // shaded, level
layout(binding = kUnitResidual) uniform sampler2D t_residual;
layout(binding = kImageDeviation, r32f) uniform writeonly image2D o_deviation;  // of one sample; 0 where nothing was shaded
layout(binding = kImageResiduals, rgba32f) uniform writeonly image2DArray o_residuals;  // [layer][tile]: sums over points of r^2, noise in it, item variance; count
layout(std430, binding = kBufferTileSums) writeonly buffer Sums { vec4 b_sums[]; };  // [2 tile]: sum of deviation * share, sum of share, points that came round the light list, items; their items
/// Degrees of freedom of the prediction, and the largest number that one neighbour contributes.
const float kPredicted = 1.0, kNeighbour = 1.5;

/// Interpolation that errs by more than this many variances of an item is useless; larger errors are clamped to it.
const float kMostKappa = 10.0;

#include "bandwidth/block_share.glsl"

float brightness2(ivec2 pixel) {
  vec3 mean = texelFetch(t_mean, pixel, 0).rgb;
  return dot(mean, mean);
}

vec2 squares(ivec2 pixel) {  // sum of squares and its degrees of freedom
  return vec2(texelFetch(t_spread, pixel, 0).x, max(texelFetch(t_mean, pixel, 0).w - 1.0, 0.0));
}

float deviation(ivec2 pixel, vec2 own, int level) {
  vec2 sum = own;
  float brightness = 0.0;
  for (int k = 0; k < 4; ++k) {
    ivec2 q = pixel + (ivec2(k & 1, k >> 1) * 2 - 1) * (1 << level);
    if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, u_frame.size.xy))) continue;
    vec2 s = squares(q);
    s *= s.y > 0.0 ? min(s.y, kNeighbour) / s.y : 0.0;
    sum += s;
    brightness += s.y * brightness2(q);
  }
  // Items are means of sampling.y samples each.
  float measured = sum.x * float(u_frame.sampling.y), predicted = texelFetch(t_pyramid, pixel / 2, 0).z;
  float squared = (measured + kPredicted * predicted * predicted) / (sum.y + kPredicted);
  // A single item does not show its deviation. A point much brighter than those around is assumed to deviate in proportion.
  if (own.y <= 0.0 && brightness > 0.0) squared = max(squared, measured * brightness2(pixel) / brightness);
  return sqrt(squared);
}

void main() {
  int id = int(linear_id());
  ivec2 tile = tile_of(id, 0);
  if (tile.x < 0) return;
  ivec2 corner = kTile * tile;
  int top = u_frame.size.w;
  float round_items = 0.0;
  vec4 sums = vec4(0.0), residuals[16];
  for (int layer = 0; layer < kClasses * top; ++layer) residuals[layer] = vec4(0.0);
  for (int k = 0; k < kTile * kTile; ++k) {
    ivec2 pixel = corner + ivec2(k % kTile, k / kTile);
    if (any(greaterThanEqual(pixel, u_frame.size.xy))) continue;
    uvec4 mark = texelFetch(t_marks, pixel, 0);
    float d = 0.0;
    if (mark.x != 0u) {
      int enters = level_entered(pixel.x, pixel.y, top), level = min(int(mark.y), enters);
      float share = block_share(level);
      vec2 own = squares(pixel);
      d = deviation(pixel, own, level);
      sums.xy += vec2(d, 1.0) * share;
      float items = own.y + 1.0;
      sums.w += items;
      if (items * float(u_frame.sampling.y) > float(u_frame.environment_size.w)) {
        sums.z += 1.0;
        round_items += items;
      }
      float residual = texelFetch(t_residual, pixel, 0).x;
      if (residual >= 0.0 && own.y > 0.0) {
        // The noise is that of the point's own items: pooled or predicted noise would look like an error of interpolation, or hide one. Points
        // with little noise weigh more, bright ones no more than others. Outliers are left to point_kappa.
        float item = own.x / own.y, pooled = item_variance(d, u_frame.sampling.y), fall = noise_fall(items);
        float weight = 1.0 / ((fall + 0.05) * max(pooled, 1e-30));
        residuals[worth_layer(enters, int(mark.y))] += vec4(weight * vec3(min(residual, kMostKappa * max(item, pooled)), item * fall, item), 1.0);
      }
    }
    imageStore(o_deviation, pixel, vec4(d));
  }
  for (int layer = 0; layer < kClasses * top; ++layer) imageStore(o_residuals, ivec3(tile, layer), residuals[layer]);
  b_sums[2 * (u_tiles.x + id)] = sums;
  b_sums[2 * (u_tiles.x + id) + 1] = vec4(round_items, 0.0, 0.0, 0.0);
}
