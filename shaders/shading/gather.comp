// Averages the work items of each shaded point. ACCUMULATE: updates the mean of all its items since something last moved, and the
// spread of the items around that mean, from which the next frame's sample counts follow.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
struct ShadedPoint {
  uint pixel, first_item, item_count, level;
};
struct List {
  uint items, points, groups_x, groups_y, groups_z, samples, visible, overflow;
};
layout(std430, binding = kBufferCounters) readonly buffer Counters { List b_lists[2]; };
layout(std430, binding = kBufferPoints) readonly buffer Points { ShadedPoint b_points[]; };
layout(binding = kUnitPartial) uniform samplerBuffer t_partial;
layout(binding = kImageRadiance, rgba32f) uniform writeonly image2D o_radiance;
#if ACCUMULATE
layout(binding = kImageMean, rgba32f) uniform image2D io_mean;   // mean, number of items
// Sum of squared deviations of the items, mean over R, G, B; with textures also the mean of what the base colour scales.
#if TEXTURES
layout(binding = kImageSpread, rg32f) uniform image2D io_spread;
#else
layout(binding = kImageSpread, r32f) uniform image2D io_spread;
#endif
#endif
uniform int u_list;
layout(binding = kUnitSurface) uniform usampler2D t_surface;
#include "bandwidth/without_base.glsl"

// A picture never holds NaN or infinity, whatever a table holds.
vec4 finite(vec4 v) { return any(isnan(v)) || any(isinf(v)) ? vec4(0.0) : v; }

void main() {
  uint count = b_lists[u_list].points;
  for (uint id = gl_GlobalInvocationID.x; id < count; id += gl_NumWorkGroups.x * 64u) {
    ShadedPoint point = b_points[id];
    ivec2 pixel = ivec2(point.pixel & 65535u, point.pixel >> 16u);
#if ACCUMULATE
    // Source: Welford 1962, "Note on a method for calculating corrected sums of squares and products".
    vec4 mean = imageLoad(io_mean, pixel);
    vec2 spread = imageLoad(io_spread, pixel).xy;
    for (uint i = 0u; i < point.item_count; ++i) {
      vec4 value = finite(texelFetch(t_partial, int(point.first_item + i)));
      mean.w += 1.0;
      vec3 before = value.rgb - mean.rgb;
      mean.rgb += before / mean.w;
      spread += vec2(dot(before, value.rgb - mean.rgb) * (1.0 / 3.0), (value.w - spread.y) / mean.w);
    }
    imageStore(io_mean, pixel, mean);
    imageStore(io_spread, pixel, vec4(spread, 0.0, 0.0));
    imageStore(o_radiance, pixel, without_base(vec4(mean.rgb, spread.y), texelFetch(t_surface, pixel, 0)));
#else
    vec4 sum = vec4(0.0);
    for (uint i = 0u; i < point.item_count; ++i) sum += texelFetch(t_partial, int(point.first_item + i));
    imageStore(o_radiance, pixel, without_base(finite(sum / float(max(point.item_count, 1u))), texelFetch(t_surface, pixel, 0)));
#endif
  }
}
