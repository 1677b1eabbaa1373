// While the environment rotates: the number of samples of each marked point in this frame, and the share of its history that is kept. One
// invocation handles a 4 x 4 block and appends its points with one atomic per list.
//
// A point's mean m of earlier frames becomes kept m + mean(f(now) - kept f(before)), where f(now) and f(before) are the same sample of the
// estimator under the current and under the previous rotation. This is unbiased for every value of `kept`, so a large rotation, a wrong
// prediction or a long history add only noise. With correlation rho between both, a history equivalent to N samples and n new
// ones, the best share is kept = rho N / (N + n); the mean is then equivalent to 1 / (kept^2 / N + (1 + kept^2 - 2 kept rho) / n) samples.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/constants.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/gbuffer.glsl"
#include "shared/material_table.glsl"
#include "rotation/item.glsl"
layout(binding = kUnitSurface) uniform usampler2D t_surface;
layout(binding = kUnitHistory) uniform sampler2D t_history;   // mean, samples that it is worth
layout(binding = kUnitRenewed) uniform usampler2D t_renewed;  // frame that it was last renewed in
layout(std430, binding = kBufferTemporalCounters) buffer Temporal { TemporalCounters b_temporal; };
layout(binding = kUnitPyramid) uniform sampler2D t_pyramid;
layout(binding = kUnitAxes) uniform sampler2D t_axes;         // w: nu_theta, cycles/rad
layout(binding = kImageMarks, rgba8ui) uniform uimage2D io_marks;
struct Item {
  uint pixel, packed_item;
};
struct ShadedPoint {
  uint pixel, first_item, item_count, packed_point;
};
struct List {
  uint items, points, groups_x, groups_y, groups_z, samples, more_items, more_points;
};
layout(std430, binding = kBufferCounters) buffer Counters { List b_lists[2]; };
layout(std430, binding = kBufferMeasuredItems) writeonly buffer MeasuredItems { Item b_measured_items[]; };
layout(std430, binding = kBufferMeasuredPoints) writeonly buffer MeasuredPoints { ShadedPoint b_measured_points[]; };
layout(std430, binding = kBufferAnalyticItems) writeonly buffer AnalyticItems { Item b_analytic_items[]; };
layout(std430, binding = kBufferAnalyticPoints) writeonly buffer AnalyticPoints { ShadedPoint b_analytic_points[]; };
uniform int u_item_capacity;
uniform float u_sample_scale;
uniform float u_rotation_rad;  // rotation since the frame before, positive
uniform int u_frame_number;

#include "bandwidth/block_share.glsl"

/// Cost of a sample that is evaluated under both rotations, relative to one.
const float kReuseCost = 1.7;
/// Number of samples that a point's mean should be equivalent to, relative to a frame without history. With a smaller factor many points need about
/// the least number of samples and drop their history, and a frame has more samples at a larger error.
const float kWorth = 1.3;
/// From the energy-weighted mean bandwidth to the root mean square frequency of a sample's change over the rotation.
const float kBandwidthToChange = 0.25;

struct Plan {
  int items, size_log2;
  uint kept;
  float worth;
};

/// Number n of new samples with which a history equivalent to `have` samples becomes equivalent to `wanted`:
/// 1 / wanted = s (v + s (1 - rho^2)) / (v + s), s = 1 / n, v = 1 / have, solved for n.
float new_samples(float have, float wanted, float rho) {
  float d = wanted - have;
  return 0.5 * (d + sqrt(d * d + 4.0 * (1.0 - rho * rho) * wanted * have));
}

/// `have`: number of samples that the point's history is equivalent to.
Plan plan_point(float wanted, float have, float nu) {
  float x = kBandwidthToChange * 2.0 * kPi * nu * u_rotation_rad;
  float rho = exp(-0.5 * x * x);
  float fewest = exp2(float(least_item_log2()));
  wanted = max(wanted, fewest);
  float n = max(new_samples(have, wanted, rho), fewest);
  bool reuses_history = have > 0.0 && kReuseCost * n <= wanted;
  n = reuses_history ? n : wanted;
  Plan plan;
  int least = least_item_log2();
  plan.size_log2 = reuses_history ? least : clamp(int(log2(n) + 0.25), least, least + 3);
  plan.items = clamp(int(n * exp2(float(-plan.size_log2)) + 0.5), 1, 4096);
  n = float(plan.items << plan.size_log2);
  plan.kept = reuses_history ? uint(kKeptSteps * min(rho * have / (have + n), 0.99)) : 0u;
  float kept = float(plan.kept) / kKeptSteps;
  plan.worth = 1.0 / (kept * kept / max(have, 1.0) + (1.0 + kept * kept - 2.0 * kept * rho) / n);
  return plan;
}

float wanted_samples(ivec2 pixel, int level, float mean_deviation) {
  float predicted = texelFetch(t_pyramid, pixel / 2, 0).z;
  float relative = mean_deviation > 0.0 ? predicted / mean_deviation : 1.0;
  return float(u_frame.sampling.x) * (0.25 + 0.75 * min(relative, 64.0)) * block_share_of_view(level) * u_sample_scale * kWorth;
}

float samples_so_far(ivec2 pixel) {
  return texelFetch(t_renewed, pixel, 0).x + 1u == uint(u_frame_number) ? texelFetch(t_history, pixel, 0).w : 0.0;
}

void main() {
  int id = int(linear_id());
  ivec2 tile = tile_of(id, 2);
  if (tile.x < 0) return;
  ivec2 corner = kTile * tile + 4 * ivec2(id & 1, (id >> 1) & 1);
  float mean_deviation = texelFetch(t_pyramid, ivec2(0), textureQueryLevels(t_pyramid) - 1).z;
  uint marked = 0u, levels[16];
  for (int k = 0; k < 16; ++k) {
    ivec2 pixel = corner + ivec2(k & 3, k >> 2);
    uvec4 mark = all(lessThan(pixel, u_frame.size.xy)) ? imageLoad(io_marks, pixel) : uvec4(0u);
    marked |= min(mark.x, 1u) << uint(k);
    levels[k] = mark.y;
  }
  // Few are marked, and software devices run a loop as often as the longest of eight invocations needs.
  uint counts[16], points_packed[16];
  uvec2 small_items = uvec2(0u), large_items = uvec2(0u), points = uvec2(0u), samples = uvec2(0u);
  uint continued = 0u;
  for (uint left = marked; left != 0u; left &= left - 1u) {
    int k = findLSB(left);
    ivec2 pixel = corner + ivec2(k & 3, k >> 2);
    int level = int(levels[k]);
    Plan plan = plan_point(wanted_samples(pixel, level, mean_deviation), samples_so_far(pixel), texelFetch(t_axes, pixel / 2, 0).w);
    continued += plan.kept > 0u ? 1u : 0u;
    bool measured = (material_words(int(texelFetch(t_surface, pixel, 0).z >> 16u), 6).x & kMaterialMeasured) != 0u;
    uint n = uint(plan.items << plan.size_log2);
    imageStore(io_marks, pixel, uvec4(1u, level, min(uint(findMSB(n)), 255u), 1u));
    counts[k] = uint(plan.items) | (measured ? 0u : 0x80000000u);
    points_packed[k] = pack_temporal_point(level, plan.size_log2, plan.kept, plan.worth);
    uvec2 items = measured ? uvec2(plan.items, 0u) : uvec2(0u, plan.items);
    small_items += is_large_item(plan.size_log2) ? uvec2(0u) : items;
    large_items += is_large_item(plan.size_log2) ? items : uvec2(0u);
    points += measured ? uvec2(1u, 0u) : uvec2(0u, 1u);
    samples += measured ? uvec2(n, 0u) : uvec2(0u, n);
  }
  if (continued > 0u) atomicAdd(b_temporal.continued, continued);
  uvec2 next_small = uvec2(0u), next_large = uvec2(0u), next_point = uvec2(0u);
  for (int list = 0; list < 2; ++list) {
    if (points[list] == 0u) continue;
    atomicAdd(b_lists[list].items, small_items[list] + large_items[list]);
    next_small[list] = atomicAdd(b_temporal.small_items[list], small_items[list]);
    next_large[list] = atomicAdd(b_temporal.large_items[list], large_items[list]);
    next_point[list] = atomicAdd(b_lists[list].points, points[list]);
    atomicAdd(b_lists[list].samples, samples[list]);
  }
  for (uint left = marked; left != 0u; left &= left - 1u) {
    int k = findLSB(left);
    ivec2 pixel = corner + ivec2(k & 3, k >> 2);
    int list = int(counts[k] >> 31u);
    int size_log2 = unpack_temporal_point(points_packed[k]).size_log2;
    bool large = is_large_item(size_log2);
    uint n = counts[k] & 0x7fffffffu, before = large ? next_large[list] : next_small[list];
    // Beyond the capacity nothing is written; the host reads the count and schedules again with fewer samples.
    uint written = before + n <= uint(u_item_capacity) ? n : 0u;
    uint first = large ? uint(u_item_capacity) - before - written : before;
    uint packed_pixel = uint(pixel.x) | (uint(pixel.y) << 16u);
    ShadedPoint point = ShadedPoint(packed_pixel, first, written, points_packed[k]);
    if (list == 0) b_measured_points[next_point.x] = point;
    else b_analytic_points[next_point.y] = point;
    for (uint i = 0u; i < written; ++i) {
      Item item = Item(packed_pixel, temporal_item_of(points_packed[k], uint(u_frame_number) * n + i, size_log2));
      if (list == 0) b_measured_items[first + i] = item;
      else b_analytic_items[first + i] = item;
    }
    next_small[list] += large ? 0u : n;
    next_large[list] += large ? n : 0u;
    next_point[list] += 1u;
  }
}
