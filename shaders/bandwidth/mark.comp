// Decides which grid points are shaded. A point enters the grid at the largest level whose spacing divides its coordinates. It is
// shaded when that is the coarsest level, when the predicted spacing is finer than the next coarser grid, or when the coarser points
// around it lie on other surfaces or across a crease. One invocation handles a 4 x 4 block and appends its points with one atomic per list.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/constants.glsl"
#ifdef REFLECTED
uniform ivec2 u_band;  // first row, rows
uniform int u_frames;  // accumulated before
uniform int u_panes;   // bit k: reflector k lets light through, and so adds little
#endif
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/gbuffer.glsl"
#include "shared/material_table.glsl"
layout(binding = kUnitSurface) uniform usampler2D t_surface;
layout(binding = kUnitDepth) uniform sampler2D t_depth;
#if BANDWIDTH
layout(binding = kUnitAxes) uniform sampler2D t_axes;        // w: nu_theta, cycles/rad
layout(binding = kUnitPyramid) uniform sampler2D t_pyramid;  // level 0: quads
#include "bandwidth/bilateral.glsl"
#endif
#if VISIBILITY
layout(binding = kUnitSkyVisibility) uniform sampler2D t_sky_visibility;  // of sky_visibility.comp
#endif
#if REFINE
layout(binding = kImageMarks, rgba8ui) uniform uimage2D io_marks;  // shaded, level of the first frame, log2 of samples, 1 if visible, 3 in plain quads
#define o_marks io_marks
#else
layout(binding = kImageMarks, rgba8ui) uniform writeonly uimage2D o_marks;  // shaded, level, log2 of samples, 1 if visible, 3 in plain quads
#endif
struct Item {
  uint pixel, first_sample;
};
struct ShadedPoint {
  uint pixel, first_item, item_count, level;
};
struct List {
  uint items, points, groups_x, groups_y, groups_z, samples, visible, overflow;
};
layout(std430, binding = kBufferCounters) buffer Counters { List b_lists[2]; };
layout(std430, binding = kBufferMeasuredItems) writeonly buffer MeasuredItems { Item b_measured_items[]; };
layout(std430, binding = kBufferMeasuredPoints) writeonly buffer MeasuredPoints { ShadedPoint b_measured_points[]; };
layout(std430, binding = kBufferAnalyticItems) writeonly buffer AnalyticItems { Item b_analytic_items[]; };
layout(std430, binding = kBufferAnalyticPoints) writeonly buffer AnalyticPoints { ShadedPoint b_analytic_points[]; };
uniform int u_item_capacity;
uniform float u_sample_scale;
#if REFINE
// While nothing moves: what earlier frames have measured.
layout(binding = kUnitMean) uniform sampler2D t_mean;            // mean, number of items
layout(binding = kUnitDeviation) uniform sampler2D t_deviation;  // of one sample
layout(binding = kUnitWorth) uniform sampler2DArray t_worth;     // [layer][tile]: kappa, sample share
layout(binding = kUnitResidual) uniform sampler2D t_residual;
layout(binding = kImageMarkedRadiance, rgba32f) uniform writeonly image2D o_radiance;
uniform float u_items_per_deviation;
uniform float u_least_deviation;
#endif
#if BANDWIDTH
uniform float u_early_share;  // while nothing moves: share of the finest level's points that were to be shaded without need by now
#endif

#if BANDWIDTH
#include "shared/interpolation.glsl"
#endif
#if BANDWIDTH && !REFINE
/// Points per cycle of the predicted bandwidth at quality 1. Nyquist requires two at the upper end of the band, but most of a picture's energy has
/// much lower frequencies. With min(nu_L, nu_rho) as prediction (then 4 points), 2.5 was best for matte and 5 for chrome spheres under Grace Cathedral.
const float kPointsPerCycle = 5.0;

vec4 picture_mean() { return texelFetch(t_pyramid, ivec2(0), textureQueryLevels(t_pyramid) - 1); }

/// Share of a neighbouring block's bandwidth that is applied here, so that adjacent levels differ by two at most. The full bandwidth costs 7 to
/// 25 % more samples, in bands around sharp features, at a larger error in seven scenes (but 1 and 3 % smaller for chrome and matte at 256
/// samples). Without it chrome and steep gradients get too few points (error of chrome 0.6 to 0.9 % at 256 samples).
const float kNeighbourShare = 0.25;

/// Weight of a relative error by the radiance it belongs to; the square root approximates the compression by the eye and the tone curve.
float error_weight(float radiance, float mean_radiance) { return clamp(sqrt(radiance / mean_radiance), 0.35, 3.0); }

/// Bandwidth (cycles/px) of a block, weighted by its radiance.
float weighed_bandwidth(ivec2 block, int level, float mean_radiance) {
  vec4 b = texelFetch(t_pyramid, clamp(block, ivec2(0), textureSize(t_pyramid, level - 1) - 1), level - 1);
  return b.x * error_weight(b.y, mean_radiance);
}

bool carries(float own, float largest_around, int level) {
  return max(own, kNeighbourShare * largest_around) * float(1 << level) * kPointsPerCycle * u_frame.quality.x <= 1.0;
}

/// True when points 2^level apart sample the bandwidth of the block around `pixel` densely enough, and a share of the bandwidth of its eight
/// neighbours: interpolation uses their values here.
bool block_carries(ivec2 pixel, int level, float mean_radiance) {
  ivec2 block = min(pixel >> level, textureSize(t_pyramid, level - 1) - 1);
  float own = 0.0, largest = 0.0;
  for (int k = 0; k < 9; ++k) {
    float nu = weighed_bandwidth(block + ivec2(k % 3, k / 3) - 1, level, mean_radiance);
    own = k == 4 ? nu : own;
    largest = max(largest, nu);
  }
  return carries(own, largest, level);
}

/// The same for the four quads of a block of 4 x 4 points, whose neighbours overlap; one bit each.
int quads_carry(ivec2 corner, float mean_radiance) {
  ivec2 quad = corner >> 1;
  vec4 own = vec4(0.0), largest = vec4(0.0);
  for (int row = -1; row <= 2; ++row) {
    vec4 nu;
    for (int column = -1; column <= 2; ++column) nu[column + 1] = weighed_bandwidth(quad + ivec2(column, row), 1, mean_radiance);
    vec2 around = vec2(max(max(nu.x, nu.y), nu.z), max(max(nu.y, nu.z), nu.w));
    if (row < 2) largest.xy = max(largest.xy, around);
    if (row > -1) largest.zw = max(largest.zw, around);
    if (row == 0) own.xy = nu.yz;
    if (row == 1) own.zw = nu.yz;
  }
  int bits = 0;
  for (int k = 0; k < 4; ++k) bits |= carries(own[k], largest[k], 1) ? 1 << k : 0;
  return bits;
}

/// Largest relative error of interpolation, at quality 1, that may come from a point's normal differing from the one interpolated between its
/// neighbours. It falls like noise, with the square of the quality. By error squared times samples in seven scenes at 16 to 1024 samples a pixel
/// 0.15 was best, and 0.08 and 0.3 cost up to 8 % more; nu_theta was then min(nu_L, nu_rho), a fifth higher.
const float kNormalError = 0.124;

/// The same for the visibility in a lobe's direction. Where it changes within a few pixels, at strips and bevels, the light has kinks that the
/// predicted bandwidth does not contain. Relative to the visibility, or to kLeastVisibility where that is smaller.
const float kVisibilityError = 0.15, kLeastVisibility = 0.2;

/// The weights of the points around are alike when their sum lacks at most this of their number: then none is below a half.
const float kUnlike = 0.5;

vec4 normal_and_open(Guide g) { return vec4(g.normal, g.open); }

/// First bit: the coarser points around lie on the same surface, and normal and visibility vary linearly between them. Across a crease too shallow
/// to be an edge, interpolation errs by the slope of the light over directions (at most 2 pi nu_theta for a light like 1 + cos) times the
/// deviation of the normal, however dense the points are.
/// `around`: weighted sum of the normals and visibilities of `count` points; `sum`: of their weights. Inside a pixel one of two neighbours is enough:
/// points beyond an edge belong to the other surface, and a smooth surface hardly changes over half a pixel. `weights`: of both errors.
/// Second bit: the points around have similar weights, so that the finest level need not compare them again (quads.comp).
int agrees(Guide center, vec4 around, float sum, float count, int level, vec2 weights) {
  float least = level < findMSB(u_frame.size.z) && count == 2.0 ? 0.4 : 0.55 * count;
  vec4 between = around / sum;
  bool agree = sum > least && length(between.xyz - center.normal) * weights.x <= kNormalError;
#if VISIBILITY
  agree = agree && abs(between.w - center.open) * weights.y <= kVisibilityError * max(max(between.w, center.open), kLeastVisibility);
#endif
  return (agree ? 1 : 0) | (sum >= count - kUnlike ? 2 : 0);
}

/// Weights of a quad's errors of normals and of visibility.
vec2 error_weights(ivec2 quad, float mean_radiance) {
  float quality = u_frame.quality.x, weight = error_weight(texelFetch(t_pyramid, quad, 0).y, mean_radiance) * quality * quality;
  return weight * vec2(2.0 * kPi * texelFetch(t_axes, quad, 0).w, 1.0);
}

Guide load_guide_or_none(ivec2 pixel) {
  Guide g = load_guide(min(pixel, u_frame.size.xy - 1));
  g.valid = g.valid && all(lessThan(pixel, u_frame.size.xy));
#if VISIBILITY
  g.open = texelFetch(t_sky_visibility, min(pixel, u_frame.size.xy - 1), 0).x;
#endif
  return g;
}

int neighbours_agree(Guide center, ivec2 pixel, int level, vec2 weights) {
  vec4 around = vec4(0.0);
  int s = 1 << level;
  ivec2 odd = (pixel >> level) & 1;
  ivec2 lower = pixel - odd * s;
  float sum = 0.0;
  for (int k = 0; k < 4; ++k) {
    ivec2 o = ivec2(k & 1, k >> 1);
    if (any(greaterThan(o, odd))) continue;
    ivec2 q = lower + 2 * o * s;
    if (any(greaterThanEqual(q, u_frame.size.xy))) continue;
    Guide neighbour = load_guide_or_none(q);
    float weight = bilateral_weight(center, neighbour, float(s));
    around += weight * normal_and_open(neighbour);
    sum += weight;
  }
  return agrees(center, around, sum, float((1 + odd.x) * (1 + odd.y)), level, weights);
}

/// The same between two points of a row or column that are loaded already.
int agrees_between(Guide center, Guide first, Guide last, int level, vec2 weights) {
  float step = float(1 << level), w0 = bilateral_weight(center, first, step), w1 = bilateral_weight(center, last, step);
  return agrees(center, w0 * normal_and_open(first) + w1 * normal_and_open(last), w0 + w1, 2.0, level, weights);
}

int agrees_amid(Guide center, Guide near, Guide right, Guide below, Guide far, int level, vec2 weights) {
  float step = float(1 << level), w0 = bilateral_weight(center, near, step), w1 = bilateral_weight(center, right, step);
  float w2 = bilateral_weight(center, below, step), w3 = bilateral_weight(center, far, step);
  vec4 around = w0 * normal_and_open(near) + w1 * normal_and_open(right) + w2 * normal_and_open(below) + w3 * normal_and_open(far);
  return agrees(center, around, w0 + w1 + w2 + w3, 4.0, level, weights);
}

/// For the three points of a quad that enter at the finest level, between the same four coarser ones: one bit each (bits 1 to 3), and bit 16
/// where all three give those similar weights.
int finest_agree(ivec2 pixel, Guide near, Guide right, Guide below, Guide far, vec2 weights) {
  Guide beside = load_guide_or_none(pixel + ivec2(1, 0)), under = load_guide_or_none(pixel + ivec2(0, 1)), amid = load_guide_or_none(pixel + 1);
  int x = agrees_between(beside, near, right, 0, weights), y = agrees_between(under, near, below, 0, weights);
  int both = agrees_amid(amid, near, right, below, far, 0, weights);
  return (x & 1) << 1 | (y & 1) << 2 | (both & 1) << 3 | (x & y & both & 2) << 15;
}

/// For a block of 4 x 4 points, whose neighbours overlap: four bits a quad; from bit 16 on one bit a quad, for similar weights at the finest level.
int block_agrees(ivec2 corner, vec2 weights[4]) {
  Guide a = load_guide_or_none(corner), b = load_guide_or_none(corner + ivec2(2, 0)), c = load_guide_or_none(corner + ivec2(4, 0));
  Guide d = load_guide_or_none(corner + ivec2(0, 2)), e = load_guide_or_none(corner + 2), f = load_guide_or_none(corner + ivec2(4, 2));
  Guide g = load_guide_or_none(corner + ivec2(0, 4)), h = load_guide_or_none(corner + ivec2(2, 4)), i = load_guide_or_none(corner + 4);
  ivec4 quads = ivec4(finest_agree(corner, a, b, d, e, weights[0]), finest_agree(corner + ivec2(2, 0), b, c, e, f, weights[1]),
                      finest_agree(corner + ivec2(0, 2), d, e, g, h, weights[2]), finest_agree(corner + 2, e, f, h, i, weights[3]));
  quads |= 1 & ivec4(neighbours_agree(a, corner, level_entered(corner.x, corner.y, u_frame.size.w), weights[0]), agrees_between(b, a, c, 1, weights[1]),
                     agrees_between(d, a, g, 1, weights[2]), agrees_amid(e, a, c, g, i, 1, weights[3]));
  ivec4 points = (quads & 15) << ivec4(0, 4, 8, 12), alike = (quads & 65536) << ivec4(0, 1, 2, 3);
  ivec2 sum = points.xy + points.zw + alike.xy + alike.zw;
  return sum.x + sum.y;
}
#endif

#if BANDWIDTH
#include "bandwidth/block_share.glsl"

/// Least samples and least items that a new point gets while nothing moves: a single item has no variance from which to estimate its noise.
const float kFirstSamples = 64.0, kFirstItems = 2.0;
float first_items() { return max(kFirstSamples / float(u_frame.sampling.y), kFirstItems); }

float unit_hash(ivec2 pixel) {
  uint x = uint(pixel.x) * 0x9E3779B1u ^ uint(pixel.y) * 0x85EBCA77u;
  x = (x ^ (x >> 15u)) * 0x2C1B3C6Du;
  x = (x ^ (x >> 12u)) * 0x297A2D39u;
  return float((x ^ (x >> 15u)) >> 8u) * (1.0 / 16777216.0);
}

/// A few points are shaded before they are needed, to measure the error of interpolation. In the end all are, so that no feature is missed for good.
bool is_shaded_early(ivec2 pixel, int enters) { return unit_hash(pixel) < u_early_share * float(1 << (2 * enters)); }
#endif

#if REFINE
#include "bandwidth/wanted.glsl"
#if TEXTURES
layout(binding = kUnitSpread) uniform sampler2D t_spread;  // y: mean of what the base colour scales
#endif
#include "bandwidth/without_base.glsl"

/// Standard deviation of one sample at a point that is shaded for the first time: the mean of the coarser points around it, or half of the
/// prediction if that is larger, because missing a mirrored lamp between them is worse than a few samples too many.
float new_deviation(ivec2 pixel, int level, float predicted) {
  int s = 1 << level;
  ivec2 odd = (pixel >> level) & 1, lower = pixel - odd * s;
  vec2 sum = vec2(0.0);
  for (int k = 0; k < 4; ++k) {
    ivec2 o = ivec2(k & 1, k >> 1), q = lower + 2 * o * s;
    if (any(greaterThan(o, odd)) || any(greaterThanEqual(q, u_frame.size.xy))) continue;
    float d = texelFetch(t_deviation, q, 0).x;
    sum += d > 0.0 ? vec2(d, 1.0) : vec2(0.0);
  }
  return sum.y > 0.0 ? max(sum.x / sum.y, 0.5 * predicted) : predicted;
}

/// While nothing moves, a point keeps its items. Returns the items that it still lacks to have its share of all samples so far.
uvec3 decide(ivec2 pixel, int level, vec4 mean, vec4 own, bool agree) {
  uvec4 mark = imageLoad(io_marks, pixel);
  int enters = level_entered(pixel.x, pixel.y, u_frame.size.w);
  float have = texelFetch(t_mean, pixel, 0).w;
  float d = texelFetch(t_deviation, pixel, 0).x;
  if (have <= 0.0) d = new_deviation(pixel, min(int(mark.y), enters), texelFetch(t_pyramid, pixel / 2, 0).z);
  vec2 worth = texelFetch(t_worth, ivec3(pixel / kTile, worth_layer(enters, int(mark.y))), 0).xy;
  float residual = texelFetch(t_residual, pixel, 0).x;
  float wanted = wanted_items(u_items_per_deviation * (d + u_least_deviation), sample_share(worth.y, enters, int(mark.y)),
                              saved_items(worth, enters, have, residual, d));
  bool shaded = mark.x != 0u || wanted >= 1.0 || is_shaded_early(pixel, enters);
  if (!shaded) return uvec3(0u, mark.y, 0u);
  float items = floor(max(wanted - have, 0.0) * u_sample_scale + 0.5);
  float first = first_items();
  // A point whose deviation is not known well yet does not get all its samples at once.
  return uvec3(1u, mark.y, uint(clamp(items, have > 0.0 ? 0.0 : first, min(4.0 * (have + first), 4096.0))));
}
#else

/// Shaded or not, its level, and its number of work items; 0 for not shaded.
uvec3 decide(ivec2 pixel, int level, vec4 mean, vec4 own, bool agree) {
#if BANDWIDTH
  int top = u_frame.size.w;
  int enters = level_entered(pixel.x, pixel.y, top);
  bool shaded = enters >= top || level <= enters || !agree;
  if (!shaded && is_shaded_early(pixel, enters)) return uvec3(1u, uint(level), uint(first_items()));
  if (!shaded) return uvec3(0u, uint(level), 0u);
  float relative = mean.z > 0.0 ? own.z / mean.z : 1.0;
  int spacing = min(level, enters);
  // Neyman allocation: samples in proportion to the deviation and to the side of the block that the point represents. A quarter of them is
  // uniform, so that a light that the prediction missed at most doubles the noise.
  float samples = float(u_frame.sampling.x) * (0.25 + 0.75 * min(relative, 64.0)) * block_share_of_view(spacing) * u_sample_scale;
  uint items = uint(clamp(ceil(samples / float(u_frame.sampling.y) - 0.25), 1.0, 4096.0));
  return uvec3(1u, uint(spacing), items);
#else
#ifdef REFLECTED
  int reflector = max(int(texelFetch(t_ray_direction, pixel, 0).w), 1) - 1;
  if (reflector < 32 && ((u_panes >> uint(reflector)) & 1) != 0) return uvec3(1u, 0u, 1u);
#endif
  return uvec3(1u, 0u, uint(max(u_frame.sampling.x / u_frame.sampling.y, 1)));
#endif
}
#endif

void main() {
  int id = int(linear_id());
#ifdef REFLECTED
  ivec2 blocks = ivec2((u_frame.size.x + 3) / 4, (u_band.y + 3) / 4);
  if (id >= blocks.x * blocks.y) return;
  ivec2 corner = 4 * ivec2(id % blocks.x, id / blocks.x) + ivec2(0, u_band.x);
#else
  ivec2 tile = tile_of(id, 2);
  if (tile.x < 0) return;
  ivec2 corner = kTile * tile + 4 * ivec2(id & 1, (id >> 1) & 1);
#endif
  uint counts[16];
  uvec2 items = uvec2(0u), points = uvec2(0u);
  uint visible = 0u, shaded = 0u;  // number, bits
  vec4 mean = vec4(0.0);
  int block_level = 0;
  int carried = 0, agree = 0;  // bits: quads of the block, points of its quads
  vec4 own = vec4(0.0);        // predicted for a quad
#if BANDWIDTH && !REFINE
  mean = picture_mean();
  float mean_radiance = max(mean.y, 1e-30);
  carried = u_frame.size.w >= 1 ? quads_carry(corner, mean_radiance) : 0;
  for (int l = 2; l <= u_frame.size.w; ++l) {
    if (!block_carries(corner, l, mean_radiance)) break;
    block_level = l;
  }
  vec2 weights[4];
  for (int quad = 0; quad < 4; ++quad) {
    ivec2 at = corner / 2 + ivec2(quad & 1, quad >> 1);
    weights[quad] = error_weights(at, mean_radiance);
  }
  agree = block_agrees(corner, weights);
#endif
  for (int quad = 0; quad < 4; ++quad) {
    ivec2 first_of_quad = corner + 2 * ivec2(quad & 1, quad >> 1);
#if BANDWIDTH && !REFINE
    own = texelFetch(t_pyramid, first_of_quad / 2, 0);
#endif
    for (int j = 0; j < 4; ++j) {
      int k = (j & 1) + 4 * (j >> 1) + 2 * (quad & 1) + 8 * (quad >> 1);
      ivec2 pixel = first_of_quad + ivec2(j & 1, j >> 1);
      counts[k] = 0u;
      if (any(greaterThanEqual(pixel, u_frame.size.xy))) continue;
      if (texelFetch(t_depth, pixel, 0).x <= 0.0) {
        imageStore(o_marks, pixel, uvec4(0u));
        continue;
      }
      uvec4 surface = texelFetch(t_surface, pixel, 0);
      int material = int(surface.z >> 16u);
      uint flags = material_words(material, 6).x;
#ifdef MATERIAL_REPLACED
      if ((flags & kMaterialReplaced) == 0u) continue;
#endif
      bool measured = (flags & kMaterialMeasured) != 0u;
      uvec3 d = decide(pixel, ((carried >> quad) & 1) != 0 ? max(block_level, 1) : 0, mean, own, ((agree >> (4 * quad + j)) & 1) != 0);
      if ((flags & kMaterialUnlit) != 0u) d = uvec3(0u, 0u, 0u);
      ++visible;
#if REFINE
      vec4 known = vec4(texelFetch(t_mean, pixel, 0).rgb, 0.0);
#if TEXTURES
      known.w = texelFetch(t_spread, pixel, 0).y;
#endif
      if (d.x != 0u && d.z == 0u) imageStore(o_radiance, pixel, without_base(known, surface));
      uint seen = imageLoad(io_marks, pixel).w;
#else
      uint seen = ((agree >> (16 + quad)) & 1) != 0 ? 3u : 1u;
#endif
      imageStore(o_marks, pixel, uvec4(d.x, d.y, d.z == 0u ? 0u : min(uint(findMSB(d.z * uint(u_frame.sampling.y))), 255u), seen));
      counts[k] = d.z | (d.y << 20u) | (measured ? 0u : 0x80000000u);
      if (d.z > 0u) {
        items += measured ? uvec2(d.z, 0u) : uvec2(0u, d.z);
        points += measured ? uvec2(1u, 0u) : uvec2(0u, 1u);
        shaded |= 1u << k;
      }
    }
  }
  if (visible == 0u) return;
  atomicAdd(b_lists[0].visible, visible);
#ifdef MARKS_ONLY
  return;  // rotation/schedule.comp lists the points
#endif
  uvec2 next_item = uvec2(0u), next_point = uvec2(0u);
  if (points.x > 0u) {
    next_item.x = atomicAdd(b_lists[0].items, items.x);
    next_point.x = atomicAdd(b_lists[0].points, points.x);
  }
  if (points.y > 0u) {
    next_item.y = atomicAdd(b_lists[1].items, items.y);
    next_point.y = atomicAdd(b_lists[1].points, points.y);
  }
  // Few are shaded, and software devices run a loop as often as the longest of eight invocations needs.
  for (uint left = shaded; left != 0u; left &= left - 1u) {
    int k = findLSB(left);
    uint n = counts[k] & 0xfffffu;
    ivec2 pixel = corner + ivec2(k & 3, k >> 2);
    uint packed_pixel = uint(pixel.x) | (uint(pixel.y) << 16u);
    uint level = (counts[k] >> 20u) & 15u;
    bool measured = (counts[k] & 0x80000000u) == 0u;
    uint first = measured ? next_item.x : next_item.y;
    // Beyond the capacity nothing is written; the host reads the count and marks again with fewer samples.
    uint kept = first + n <= uint(u_item_capacity) ? n : 0u;
    ShadedPoint point = ShadedPoint(packed_pixel, first, kept, level);
    uint begin = 0u;  // of the point's own sequence
#if REFINE
    begin = uint(texelFetch(t_mean, pixel, 0).w);
#endif
#ifdef REFLECTED
    begin = uint(u_frames) * n;
#endif
    if (measured) b_measured_points[next_point.x] = point;
    else b_analytic_points[next_point.y] = point;
    for (uint i = 0u; i < kept; ++i) {
      Item item = Item(packed_pixel, (begin + i) * uint(u_frame.sampling.y));
      if (measured) b_measured_items[first + i] = item;
      else b_analytic_items[first + i] = item;
    }
    next_point += measured ? uvec2(1u, 0u) : uvec2(0u, 1u);
    next_item += measured ? uvec2(n, 0u) : uvec2(0u, n);
  }
}
