// Bilateral upsampling of one level, in two dispatches: first the points between two coarser ones in a row or column, then the points
// in the middle of four, from the ones just filled. Along an axis, four points that lie on one smooth surface are interpolated by a cubic
// (weights -1 9 9 -1 over 16, Deslauriers and Dubuc 1989). Otherwise, and at the finest level (CUBIC 0), the two nearest are weighted
// bilaterally: the finest level has three quarters of the points, and most of their error is noise, which a cubic amplifies. In the middle of
// four points, both axes and both diagonals are mixed by weights that are larger where the picture varies less: an anisotropic kernel.
// QUADS: the finest level with several points a pixel, for the listed quads only, bilaterally from the two or four coarser points around.
// OWN: while nothing moves. Points that were shaded are interpolated too. Their own mean and the interpolated value are weighted by their errors
// as earlier frames measured them, and the difference of both is stored for the next frame.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/gbuffer.glsl"
layout(binding = kUnitScreenAxes) uniform sampler2D t_axes;  // of screen_bandwidth
layout(binding = kUnitMarks) uniform usampler2D t_marks;
#include "bandwidth/bilateral.glsl"
#include "shared/bandwidth.glsl"
#include "shared/screen_curvature.glsl"
layout(binding = kImageRadiance, rgba32f) uniform image2D io_radiance;
#if OWN
#include "shared/interpolation.glsl"
layout(binding = kUnitMean) uniform sampler2D t_mean;            // mean, number of items
layout(binding = kUnitDeviation) uniform sampler2D t_deviation;  // of one sample; 0 for what was shaded first in this frame
layout(binding = kUnitWorth) uniform sampler2DArray t_worth;     // [layer][tile]: kappa
layout(binding = kImageResidual, r32f) uniform writeonly image2D o_residual;  // squared distance of own mean and interpolated value; -1 for none
/// With a smaller sum of neighbour weights the interpolated value is ignored. Of two neighbours in a row; mark.comp uses the same limit.
const float kLeastWeight = 1.1;
#endif
#ifdef QUADS
#include "bandwidth/quads.glsl"
#endif
uniform int u_level;

#if TEXTURES
#define Stored vec4  // of base_factor.glsl
#if OWN
layout(binding = kUnitSurface) uniform usampler2D t_surface;
#include "shared/luminance.glsl"
#include "shared/material_table.glsl"
#include "bandwidth/base_factor.glsl"
#endif
Stored stored_at(ivec2 q) { return imageLoad(io_radiance, clamp(q, ivec2(0), u_frame.size.xy - 1)); }
vec4 to_store(Stored value) { return value; }
#else
#define Stored vec3  // radiance
Stored stored_at(ivec2 q) { return imageLoad(io_radiance, clamp(q, ivec2(0), u_frame.size.xy - 1)).rgb; }
vec4 to_store(Stored value) { return vec4(value, 1.0); }
#endif

// The weights depend only on the visible surfaces. FIND: computes and stores the weights of all points, and fills nothing. KEPT: reads them from
// that image, 16 bits for each of kAxes (or for the only axis): the weights of the two nearest points (8 bits each, as square roots to keep small
// ones precise), or kCubic.
#if KEPT || FIND
layout(binding = kImageWeights, rg32ui) uniform uimage2D io_weights;
#endif
const uint kCubic = 0xffffu;  // no weight is coded so
const float kWeightSteps = 254.0;

uint pack_weights(vec2 weights) {
  uvec2 code = uvec2(sqrt(min(weights, vec2(1.0))) * kWeightSteps + 0.5);
  return code.x | (code.y << 8u);
}
vec2 unpack_weights(uint packed_weights) {
  vec2 root = vec2(packed_weights & 255u, packed_weights >> 8u) * (1.0 / kWeightSteps);
  return root * root;
}

uint find_weights(Guide center, ivec2 pixel, ivec2 axis, int s) {
  float weights[4], step_px = float(s) * length(vec2(axis));
  for (int k = 1 - CUBIC; k < 3 + CUBIC; ++k) {
    ivec2 q = pixel + (2 * k - 3) * s * axis;
    bool inside = all(greaterThanEqual(q, ivec2(0))) && all(lessThan(q, u_frame.size.xy));
    q = clamp(q, ivec2(0), u_frame.size.xy - 1);
    weights[k] = inside ? bilateral_weight(center, load_guide(q), step_px * (k == 0 || k == 3 ? 3.0 : 1.0)) : 0.0;
    if (weights[k] > 0.0) weights[k] = max(weights[k], 1e-4);
  }
#if CUBIC
  if (min(min(weights[0], weights[3]), min(weights[1], weights[2])) > 0.4) return kCubic;
#endif
  return pack_weights(vec2(weights[1], weights[2]));
}

/// `evidence`: sum of the neighbours' bilateral weights, independent of the shape of the anisotropic kernel.
void store_filled(ivec2 pixel, uvec4 mark, Stored value, float evidence) {
#if OWN
  if (mark.x != 0u) {
    vec4 own = texelFetch(t_mean, pixel, 0);
    bool known = evidence >= kLeastWeight;
#if TEXTURES
    uvec4 surface = texelFetch(t_surface, pixel, 0);
    uint flags = material_words(int(surface.z >> 16u), 6).x;
    float share = tinted_share(value, flags);
    vec3 base = base_factor(value, surface, flags);
#else
    const vec3 base = vec3(1.0);
#endif
    vec3 apart = own.rgb - value.rgb * base;
    float residual = dot(apart, apart) * (1.0 / 3.0), d = texelFetch(t_deviation, pixel, 0).x;
    imageStore(o_residual, pixel, vec4(known ? residual : -1.0));
    float kappa = texelFetch(t_worth, ivec3(pixel / kTile, worth_layer(u_level, int(mark.y))), 0).x;
    kappa = point_kappa(kappa, own.w, residual, item_variance(d, u_frame.sampling.y));
    value.rgb += apart / base * (known ? own_weight(own.w, kappa) : 1.0);
#if TEXTURES
    value.w = share * luminance(value.rgb);
#endif
  }
#endif
  imageStore(io_radiance, pixel, to_store(value));
}

struct Along {
  Stored value;
  float weight;
};
/// From the points at -3, -1, 1, 3 steps along an axis.
Along along(ivec2 pixel, ivec2 axis, uint packed_weights) {
  Stored before = stored_at(pixel - axis), after = stored_at(pixel + axis);
#if CUBIC
  Stored first = stored_at(pixel - 3 * axis), last = stored_at(pixel + 3 * axis);
  if (packed_weights == kCubic) {
    Stored cubic = (9.0 * (before + after) - first - last) * 0.0625;
    // Noise must not make the cubic undershoot far below its neighbours.
    Stored low = min(min(first, last), min(before, after));
    return Along(max(cubic, low * 0.5), 2.0);
  }
#endif
  vec2 w = unpack_weights(packed_weights);
  // A point with weight 0 may never have been written, and may contain anything.
  float sum = w.x + w.y;
  Stored both = (w.x > 0.0 ? before * w.x : Stored(0.0)) + (w.y > 0.0 ? after * w.y : Stored(0.0));
  return Along(both / max(sum, 1e-12), sum);
}

#if MIDDLE
const ivec2 kAxes[4] = ivec2[4](ivec2(1, 0), ivec2(0, 1), ivec2(1, 1), ivec2(1, -1));
#endif

void fill(ivec2 pixel, ivec2 odd, int s, uvec4 mark) {
#if KEPT
  uvec2 kept = imageLoad(io_weights, pixel).xy;
  uvec4 weights = uvec4(kept & 65535u, kept >> 16u).xzyw;
#else
  Guide center = load_guide(pixel);
  uvec4 weights = uvec4(0u);
#if MIDDLE
  for (int k = 0; k < 4; ++k) weights[k] = find_weights(center, pixel, kAxes[k], s);
#else
  weights.x = find_weights(center, pixel, odd, s);
#endif
#endif
#if FIND
  imageStore(io_weights, pixel, uvec4(weights.x | (weights.y << 16u), weights.z | (weights.w << 16u), 0u, 0u));
#elif MIDDLE
  vec4 share = axis_shares(texelFetch(t_axes, pixel / 2, 0).xyz, CUBIC == 1);
  Stored value = Stored(0.0);
  float sum = 0.0;
  vec4 evidence;
  for (int k = 0; k < 4; ++k) {
    Along v = along(pixel, s * kAxes[k], weights[k]);
    float w = share[k] * v.weight + 1e-20;
    value += v.value * w;
    sum += w;
    evidence[k] = v.weight;
  }
  store_filled(pixel, mark, value / sum, max(evidence.x + evidence.y, evidence.z + evidence.w));
#else
  Along v = along(pixel, s * odd, weights.x);
  store_filled(pixel, mark, v.value, v.weight);
#endif
}

#ifdef QUADS
void main() {
  ivec2 first = listed_quad(int(linear_id()));
  if (first.x < 0) return;
  Guide around[4];
  Stored corners[4];
  for (int k = 0; k < 4; ++k) {
    ivec2 q = first + 2 * ivec2(k & 1, k >> 1);
    around[k] = load_guide(min(q, u_frame.size.xy - 1));
    around[k].valid = around[k].valid && all(lessThan(q, u_frame.size.xy));
    corners[k] = stored_at(q);
  }
  // In the middle both axes give the mean of all four points, and each diagonal the mean of its two.
  vec4 share = axis_shares(texelFetch(t_axes, first / 2, 0).xyz, false);
  vec2 diagonal_shares = 0.5 * (share.x + share.y) + share.zw;
  diagonal_shares *= 2.0 / (diagonal_shares.x + diagonal_shares.y);
  for (int j = 1; j < 4; ++j) {
    ivec2 pixel = first + ivec2(j & 1, j >> 1);
    Guide center = load_guide(pixel);
    Stored value = Stored(0.0);
    float evidence = 0.0, sum = 0.0;
    for (int k = 0; k < 4; ++k) {
      float weight = (k & ~j) == 0 ? bilateral_weight(center, around[k], 1.0) : 0.0;
      evidence += weight;
      weight *= j < 3 ? 1.0 : k == 0 || k == 3 ? diagonal_shares.x : diagonal_shares.y;
      value += weight > 0.0 ? weight * corners[k] : Stored(0.0);
      sum += weight;
    }
    uvec4 mark = texelFetch(t_marks, pixel, 0);
    if (mark.w != 0u && (OWN == 1 || mark.x == 0u)) store_filled(pixel, mark, value / max(sum, 1e-12), evidence);
  }
}
#else
void main() {
  // The invocations are the points to fill and no others: (odd, odd), or (odd, even) and then (even, odd).
  int s = 1 << u_level;
  int id = int(linear_id());
#if TILES
  // The cells of 2 s points of a tile.
  int side_log2 = 2 - u_level, shift = 2 * side_log2;
  int count = u_tiles.y << shift;
#else
  ivec2 cells = (u_frame.size.xy + 2 * s - 1) / (2 * s);
  int count = cells.x * cells.y;
#endif
  bool second = id >= count;
  if (id >= (MIDDLE == 1 ? count : 2 * count)) return;
  id = second ? id - count : id;
#if TILES
  ivec2 cell = (tile_of(id, shift) << side_log2) + ivec2(id & ((1 << side_log2) - 1), (id & ((1 << shift) - 1)) >> side_log2);
#else
  ivec2 cell = ivec2(id % cells.x, id / cells.x);
#endif
  ivec2 odd = MIDDLE == 1 ? ivec2(1, 1) : (second ? ivec2(0, 1) : ivec2(1, 0));
  ivec2 pixel = (2 * cell + odd) * s;
  if (any(greaterThanEqual(pixel, u_frame.size.xy))) return;
  uvec4 mark = texelFetch(t_marks, pixel, 0);
  if (mark.w != 0u && (OWN == 1 || FIND == 1 || mark.x == 0u)) fill(pixel, odd, s, mark);
}
#endif
