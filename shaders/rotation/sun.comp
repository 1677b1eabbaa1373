// While the environment rotates: the sun's light at each listed point, sampled separately in every frame. The sun has so few texels that a few
// samples of them are nearly free of noise, and is so small that visibility and broad lobes hardly vary over it.
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
#define POINTS_SORTED
#include "shading/point.glsl"
#if VISIBILITY == 2
#include "octree/visibility.glsl"
#elif VISIBILITY
#include "shading/visibility.glsl"
#endif
struct ShadedPoint {
  uint pixel, first_item, item_count, packed_point;
};
layout(std430, binding = kBufferPoints) readonly buffer Points { ShadedPoint b_points[]; };
layout(binding = kImageSun, rgba32f) uniform writeonly image2D o_sun;
layout(binding = kUnitSunSamples) uniform samplerBuffer t_sun_samples;  // two texels: direction, - | radiance over density, -
layout(binding = kUnitPyramid) uniform sampler2D t_pyramid;
uniform ivec3 u_range;  // points, entries of the list, samples of a point that mirrors no sun
uniform int u_frame_number;

struct Result {
  vec3 sum;
#if VISIBILITY
  VisibilityPoint visibility;
#endif
};
#define ON_SAMPLE(f, radiance, weight, wi, world, pdf, is_brdf)
#define SAMPLE_GROUP 2
#include "shading/integrate.glsl"

/// Samples of a point that mirrors the sun, that is where the sun's light is brighter than kBright times the picture's mean.
const int kMany = 64;
const float kBright = 20.0;
/// Entries of the list, the same at all points, that determine the sample count. They are separate from the samples of the mean: if those decided,
/// those that miss a narrow lobe would be kept and those that hit it be drawn again, which lost 5 to 13 % of mirrored suns.
const int kProbes = 4;

struct SunSample {
  vec3 light;  // environment frame
  vec3 value;  // without visibility
};

SunSample sun_sample(Point p, uint at, vec2 xi) {
  SunSample s;
  s.light = texelFetch(t_sun_samples, 2 * int(at)).xyz;
  s.value = vec3(0.0);
  vec3 wi = to_local(p, s.light);
  if (wi.z <= 0.0) return s;
#if MEASURED
  BrdfLookup lookup = brdf_lookup(p.slot, wi, p.wo, xi);
  LobeTerms lobe = lobe_terms(p, wi, fetch_brdf(lookup), lookup.fraction);
#else
  LobeTerms lobe = lobe_terms(p, wi);
#endif
  if (lobe_finds_sun(lobe.f_hat)) return s;
  s.value = lobe.f * texelFetch(t_sun_samples, 2 * int(at) + 1).rgb * wi.z;
  return s;
}

int sample_count(Point p) {
  float brightest = 0.0;
  for (int i = 0; i < kProbes; ++i) brightest = max(brightest, luminance(sun_sample(p, uint(i), vec2(0.5)).value));
  float mean = texelFetch(t_pyramid, ivec2(0), textureQueryLevels(t_pyramid) - 1).y;
  float relative = brightest * u_frame.environment.z / max(mean, 1e-30);
  return relative > kBright ? kMany << clamp(int(log2(relative / kBright)), 0, 3) : u_range.z;
}

void main() {
  uint id = linear_id();
  if (id >= uint(u_range.x)) return;
  uint packed_pixel = b_points[id].pixel;
  ivec2 pixel = ivec2(packed_pixel & 65535u, packed_pixel >> 16u);
  Point p = load_point(pixel);
  Result r;
#if VISIBILITY
  r.visibility = load_visibility(pixel, p.position, world_from_environment(p.n));
#endif
#if MEASURED
  g_brdf_slot = p.slot;
#endif
  uint mask = hash(uint(pixel.x) + (uint(pixel.y) << 16u) + hash(uint(u_frame.sampling.w) + uint(u_frame_number)));
  int count = sample_count(p);
  vec3 light = vec3(0.0);
  for (int i = 0; i < count; ++i) {
    uint n = uint(i);
    SunSample one = sun_sample(p, (n ^ mask) & uint(u_range.y - 1), unit_pair(hash(mask) + n * kStep3));
#if VISIBILITY
    one.value *= mean_visibility(r.visibility, world_from_environment(one.light));
#endif
    light += one.value;
  }
  light /= float(count);
  imageStore(o_sun, pixel, vec4(light * (u_frame.environment.z * p.occlusion), 0.0));
}
