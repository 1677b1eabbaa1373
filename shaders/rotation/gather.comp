// Averages the work items of each point and updates its history (schedule.comp). Points whose samples deviate far more than was predicted
// (mirrored lamps) are listed again, with the sample count for their measured deviation.
// MORE 0: first round, all points; 1: second round, only the points listed again.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "rotation/item.glsl"
struct Item {
  uint pixel, packed_item;
};
struct ShadedPoint {
  uint pixel, first_item, item_count, packed_point;
};
struct List {
  uint items, points, groups_x, groups_y, groups_z, samples, more_items, more_points;
};
// A picture never holds NaN or infinity, whatever a table holds.
vec3 finite(vec3 v) { return any(isnan(v)) || any(isinf(v)) ? vec3(0.0) : v; }
layout(std430, binding = kBufferCounters) buffer Counters { List b_lists[2]; };
layout(std430, binding = kBufferPoints) buffer Points { ShadedPoint b_points[]; };
layout(std430, binding = kBufferNextItems) writeonly buffer Items { Item b_items[]; };
layout(binding = kUnitPartial) uniform samplerBuffer t_partial;
layout(binding = kUnitPyramid) uniform sampler2D t_pyramid;
layout(binding = kImageRadiance, rgba32f) uniform writeonly image2D o_radiance;
layout(binding = kImageHistory, rgba32f) uniform image2D io_history;  // mean, samples that it is worth
layout(binding = kImageRenewed, r32ui) uniform writeonly uimage2D o_renewed;
#if SEPARATE_SUN
layout(binding = kImageGatheredSun, rgba32f) uniform readonly image2D i_sun;
vec3 sun_at(ivec2 pixel) { return finite(imageLoad(i_sun, pixel).rgb); }
#else
vec3 sun_at(ivec2 pixel) { return vec3(0.0); }
#endif
uniform int u_list;
uniform int u_frame_number;
uniform int u_item_capacity;
uniform int u_point_capacity;
uniform float u_sample_scale;

#include "bandwidth/block_share.glsl"
layout(binding = kUnitSurface) uniform usampler2D t_surface;
#include "bandwidth/without_base.glsl"

vec4 mean_of_items(ShadedPoint point, uint count) {
  vec4 sum = vec4(0.0);
  for (uint i = 0u; i < count; ++i) {
    vec4 item = texelFetch(t_partial, int(point.first_item + i));
    sum += vec4(finite(item.rgb), item.w);
  }
  return sum / float(max(count, 1u));
}

/// Items of the second round have the largest size, and a point gets at most kMostMore of them.
int more_size_log2() { return least_item_log2() + 3; }
const float kMostMore = 256.0;
/// A point gets a second round when it needs more than this many times the samples of the first.
const float kFarMore = 6.0;

/// Items by Neyman allocation for the measured deviation; 0 where the first round was nearly enough. They replace the samples of the first round,
/// because a count that depends on samples would bias their mean.
uint more_items(float variance, int level, float taken, float mean_deviation) {
  float wanted = float(u_frame.sampling.x) * sqrt(max(variance, 0.0)) / max(mean_deviation, 1e-30) * block_share_of_view(level) * u_sample_scale;
  return wanted > kFarMore * taken ? uint(clamp(wanted * exp2(float(-more_size_log2())), 1.0, kMostMore)) : 0u;
}

void main() {
  List list = b_lists[u_list];
#if MORE
  uint begin = list.points, end = min(list.points + list.more_points, uint(u_point_capacity));
#else
  uint begin = 0u, end = list.points;
  float mean_deviation = texelFetch(t_pyramid, ivec2(0), textureQueryLevels(t_pyramid) - 1).z;
#endif
  for (uint id = begin + gl_GlobalInvocationID.x; id < end; id += gl_NumWorkGroups.x * 64u) {
    ShadedPoint point = b_points[id];
    ivec2 pixel = ivec2(point.pixel & 65535u, point.pixel >> 16u);
    TemporalPoint temporal = unpack_temporal_point(point.packed_point);
#if MORE
    // The history of a point whose prediction failed is not used in the next frame.
    vec3 mean = mean_of_items(point, point.item_count).rgb;
    imageStore(io_history, pixel, vec4(mean, 0.0));
    imageStore(o_radiance, pixel, without_assumed_base(mean + sun_at(pixel), texelFetch(t_surface, pixel, 0)));
#else
    vec4 now = mean_of_items(point, point.item_count);
    vec3 mean = now.rgb;
    mean += temporal.kept > 0.0 ? temporal.kept * imageLoad(io_history, pixel).rgb : vec3(0.0);
    imageStore(io_history, pixel, vec4(mean, temporal.worth));
    imageStore(o_renewed, pixel, uvec4(u_frame_number));
    float taken = float(point.item_count << uint(temporal.size_log2));
    uint more = more_items(now.w, temporal.level, taken, mean_deviation);
    if (more > 0u) {
      uint first = atomicAdd(b_lists[u_list].more_items, more);
      // Points that do not fit keep the mean of the first round.
      bool fits = first + more <= uint(u_item_capacity);
      uint at = fits ? list.points + atomicAdd(b_lists[u_list].more_points, 1u) : uint(u_point_capacity);
      if (at < uint(u_point_capacity)) b_points[at] = ShadedPoint(point.pixel, first, more, point.packed_point);
      for (uint i = 0u; i < (fits ? more : 0u); ++i)
        b_items[first + i] = Item(point.pixel, pack_temporal_item(0x200000u + uint(u_frame_number) * 1024u + i, more_size_log2(), 0u));
    }
    imageStore(o_radiance, pixel, without_assumed_base(max(mean + sun_at(pixel), vec3(0.0)), texelFetch(t_surface, pixel, 0)));
#endif
  }
}
