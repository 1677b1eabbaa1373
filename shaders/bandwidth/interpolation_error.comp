// Error of interpolation (kappa) around each tile, by level and class, and the number of work items that the next frame would have at several
// rates. One invocation handles a tile.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/interpolation.glsl"
layout(binding = kUnitMean) uniform sampler2D t_mean;            // mean, number of items
layout(binding = kUnitDeviation) uniform sampler2D t_deviation;  // of one sample
layout(binding = kUnitPyramid) uniform sampler2D t_pyramid;
layout(binding = kUnitMarks) uniform usampler2D t_marks;     // shaded, level, -, visible
layout(binding = kUnitResidual) uniform sampler2D t_residual;
layout(binding = kUnitResiduals) uniform sampler2DArray t_residuals;  // measure.comp
layout(binding = kImageWorth, rg32f) uniform writeonly image2DArray o_worth;  // [layer][tile]: kappa, sample share of points entering there
layout(std430, binding = kBufferTileSums) writeonly buffer Sums { vec4 b_sums[]; };  // [2 tile]: items wanted at kRates rates, each sqrt(2) times the one before
uniform float u_items_per_deviation;  // the first rate
uniform float u_least_deviation;
uniform float u_typical[16];  // kappa by layer, of the picture's tiles
const int kRates = 8;
#include "bandwidth/block_share.glsl"
#include "bandwidth/wanted.glsl"

/// Pooled kappa of the tile and its eight neighbours.
float kappa_around(ivec2 tile, ivec2 tiles, int layer) {
  vec4 sums = vec4(0.0);
  for (int k = 0; k < 9; ++k) {
    ivec2 q = tile + ivec2(k % 3, k / 3) - 1;
    if (any(lessThan(q, ivec2(0))) || any(greaterThanEqual(q, tiles))) continue;
    sums += texelFetch(t_residuals, ivec3(q, layer), 0) * (k == 4 ? 1.0 : 0.5);
  }
  return pooled_kappa(sums, u_typical[layer]);
}

void main() {
  int id = int(linear_id());
  ivec2 tile = tile_of(id, 0);
  if (tile.x < 0) return;
  ivec2 corner = kTile * tile, tiles = (u_frame.size.xy + kTile - 1) / kTile;
  int top = u_frame.size.w;
  float kappas[16];
  for (int layer = 0; layer < kClasses * top; ++layer) kappas[layer] = kappa_around(tile, tiles, layer);
  // Share of each level's values that is interpolated from the coarser levels: their errors weigh more by as much.
  vec2 borrowed[8];
  vec2 deviations = vec2(0.0);
  for (int level = 0; level < top; ++level) borrowed[level] = vec2(0.0);
  for (int k = 0; k < kTile * kTile; ++k) {
    ivec2 pixel = corner + ivec2(k % kTile, k / kTile);
    if (any(greaterThanEqual(pixel, u_frame.size.xy))) continue;
    uvec4 mark = texelFetch(t_marks, pixel, 0);
    if (mark.w == 0u) continue;
    float d = texelFetch(t_deviation, pixel, 0).x;
    if (mark.x != 0u) deviations += vec2(d, 1.0);
    int enters = level_entered(pixel.x, pixel.y, top);
    if (enters >= top) continue;
    float kappa = kappas[worth_layer(enters, int(mark.y))];
    float residual = texelFetch(t_residual, pixel, 0).x;
    float have = texelFetch(t_mean, pixel, 0).w;
    float share = mark.x == 0u ? 1.0 : residual < 0.0 ? 0.0 : 1.0 - own_weight(have, point_kappa(kappa, have, residual, item_variance(d, u_frame.sampling.y)));
    borrowed[enters] += vec2(share, 1.0);
  }
  float shares[9];
  shares[0] = 1.0;
  for (int level = 0; level < top; ++level) {
    float b = borrowed[level].y > 0.0 ? borrowed[level].x / borrowed[level].y : 0.0;
    shares[level + 1] = shares[level] * sqrt(1.0 + 3.0 * b * b);
  }
  for (int layer = 0; layer < kClasses * top; ++layer)
    imageStore(o_worth, ivec3(tile, layer), vec4(kappas[layer], shares[layer / kClasses], 0.0, 0.0));
  for (int k = 0; k < kClasses; ++k) imageStore(o_worth, ivec3(tile, kClasses * top + k), vec4(kNeverInterpolate, shares[top], 0.0, 0.0));

  float items[kRates];
  for (int r = 0; r < kRates; ++r) items[r] = 0.0;
  float mean_deviation = deviations.y > 0.0 ? deviations.x / deviations.y : 0.0;
  for (int k = 0; k < kTile * kTile; ++k) {
    ivec2 pixel = corner + ivec2(k % kTile, k / kTile);
    if (any(greaterThanEqual(pixel, u_frame.size.xy))) continue;
    uvec4 mark = texelFetch(t_marks, pixel, 0);
    if (mark.w == 0u) continue;
    int enters = level_entered(pixel.x, pixel.y, top);
    vec2 worth = vec2(enters < top ? kappas[worth_layer(enters, int(mark.y))] : kNeverInterpolate, shares[enters]);
    float have = texelFetch(t_mean, pixel, 0).w, d = texelFetch(t_deviation, pixel, 0).x;
    if (have <= 0.0) d = max(mean_deviation, 0.5 * texelFetch(t_pyramid, pixel / 2, 0).z);
    // Independent of the rate, so computed once: it contains powers.
    float saved = saved_items(worth, enters, have, texelFetch(t_residual, pixel, 0).x, d);
    float share = sample_share(worth.y, enters, int(mark.y)), rate = u_items_per_deviation;
    for (int r = 0; r < kRates; ++r) {
      items[r] += max(wanted_items(rate * (d + u_least_deviation), share, saved) - have, 0.0);
      rate *= 1.41421356;
    }
  }
  int at = 2 * (u_tiles.x + id);
  b_sums[at] = vec4(items[0], items[1], items[2], items[3]);
  b_sums[at + 1] = vec4(items[4], items[5], items[6], items[7]);
}
