// Shades work items: the same number of samples of one point each, so that neighbouring invocations run loops of the same length.
// ROTATING: items of shaders/rotation (environment rotation). REUSES_HISTORY: items of points that reuse their history: each sample is evaluated under
// the previous rotation as well.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shading/linear_id.glsl"
#include "shared/frame.glsl"
#include "shared/constants.glsl"
#include "shared/latlong.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/gbuffer.glsl"
#include "shared/material_table.glsl"
#include "shared/luminance.glsl"
#include "shared/analytic.glsl"
#include "shared/merl.glsl"
#ifdef ROTATING
#include "rotation/item.glsl"
#endif
#define POINTS_SORTED
#include "shading/point.glsl"
#if VISIBILITY == 2
#include "octree/visibility.glsl"
#elif VISIBILITY
#include "shading/visibility.glsl"
#endif

struct Item {
  uint pixel;         // x | y << 16
  uint first_sample;  // of the point's sequence
};
#ifdef ROTATING
uniform ivec2 u_range;  // first item, number
#else
struct List {
  uint items, points, groups_x, groups_y, groups_z, samples, visible, overflow;
};
layout(std430, binding = kBufferCounters) readonly buffer Counters { List b_lists[2]; };
uniform int u_list;
#endif
layout(std430, binding = kBufferItems) readonly buffer Items { Item b_items[]; };
layout(std430, binding = kBufferPartial) writeonly buffer Partial { vec4 b_partial[]; };

struct Result {
  vec3 sum;
  float tinted;  // luminance of what the base colour scales, for a white one
#ifdef ROTATING
#if REUSES_HISTORY
  vec3 before;  // value of the current sample under the previous rotation
  float kept;   // share of the point's history that is kept
#endif
  float squares;
#endif
#if VISIBILITY
  VisibilityPoint visibility;
#endif
};
#ifdef ROTATING
void add_sample(inout Result r, vec3 now) {
#if REUSES_HISTORY
  vec3 v = now - r.kept * r.before;
#else
  vec3 v = now;
#endif
  r.sum += v;
  r.squares += dot(v, v) * (1.0 / 3.0);
}
#define ON_SAMPLE(f, radiance, weight, wi, world, pdf, is_brdf) add_sample(result, f * radiance * weight)
#else
void add_sample(inout Result r, vec3 f, float tinted, vec3 light) {
  r.sum += f * light;
  r.tinted += tinted * luminance(light);
}
#define ON_SAMPLE(f, radiance, weight, wi, world, pdf, is_brdf) add_sample(result, f, lobe.tinted, radiance * weight)
#endif
#ifdef ROTATING
#define SAMPLE_GROUP 2
#else
#define SAMPLE_GROUP 4
#endif
#include "shading/integrate.glsl"
#if LIGHTS
#include "shading/lights.glsl"
#endif

void main() {
  uint id = linear_id();
#ifdef ROTATING
  if (id >= uint(u_range.y)) return;
  id += uint(u_range.x);
#else
  if (id >= b_lists[u_list].items) return;
#endif
  Item item = b_items[id];
  ivec2 pixel = ivec2(item.pixel & 65535u, item.pixel >> 16u);
  Point p = load_point(pixel);
  Result result;
  result.sum = vec3(0.0);
  result.tinted = 0.0;
#if VISIBILITY
  result.visibility = load_visibility(pixel, p.position, world_from_environment(p.n));
#endif
#ifdef ROTATING
  TemporalItem temporal = unpack_temporal_item(item.first_sample);
#if REUSES_HISTORY
  result.kept = temporal.kept;
#endif
  result.squares = 0.0;
  int count = temporal.samples;
  uint first_sample = temporal.first_sample;
#else
  int count = u_frame.sampling.y;
#ifdef REFLECTED
  uint first_sample = item.first_sample;  // points of one frame differ in their counts
#else
  uint first_sample = item.first_sample + uint(u_frame.sampling.z);
#endif
#endif
  integrate(p, pixel, first_sample, count, result);
  float sky_scale = u_frame.environment.z * p.occlusion;
  vec3 sum = result.sum * sky_scale;
#ifdef ROTATING
  // Of one sample, from the terms of the sum.
  float spread = (float(count) * result.squares - dot(result.sum, result.sum) * (1.0 / 3.0)) * sky_scale * sky_scale;
#endif
#if LIGHTS
#if VISIBILITY == 2
  g_light_visibility = result.visibility;
#endif
  vec4 lights = direct_lights(p, hash(uint(pixel.x) + (uint(pixel.y) << 16u) + hash(uint(u_frame.sampling.w))), first_sample, count);
#if defined(ROTATING) && REUSES_HISTORY
  lights *= 1.0 - temporal.kept;  // lights do not rotate: before and after are equal
  // One light sample does not show the variance of light samples; its square is an upper bound.
  spread += temporal.kept > 0.0 ? float(count) * dot(lights.rgb, lights.rgb) * (1.0 / 3.0) : 0.0;
#endif
  sum += lights.rgb;
#endif
#ifdef ROTATING
  b_partial[id] = vec4(sum, spread);
#else
  float tinted = result.tinted * sky_scale;
#if LIGHTS
  tinted += lights.w;
#endif
  b_partial[id] = vec4(sum, tinted);
#endif
}
