// Per 2 x 2 quad: a few samples of the estimator, their bandwidth weighted by energy (L rho cos), and the moments that give
// the variance of the integrand. All are sums, so that neighbours on the same surface can be pooled.
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
#include "shared/bandwidth.glsl"
#define POINTS_SORTED
#include "shading/point.glsl"
#if SHADOWED == 2
#include "octree/visibility.glsl"
#elif SHADOWED
#include "shading/visibility.glsl"
layout(binding = kUnitVisibilityBandwidth) uniform samplerBuffer t_visibility_bandwidth;  // [vertex], cycles/m
#endif
#if SHADOWED || LIGHTS
layout(binding = kImageNear, rgba32f) uniform writeonly image2D o_near;  // sum w nu_x (cycles/m); of the lights: mean, variance of a sample of the environment's beside them, 1
#endif
layout(binding = kUnitBrdfBandwidth) uniform samplerBuffer t_brdf_bandwidth;                // [slot][theta_h 90][theta_d 90], cycles/rad
layout(binding = kUnitEnvironmentBandwidth) uniform samplerBuffer t_environment_bandwidth;  // [height][width][lobes + 1], cycles/rad: seen through each lobe, then as it is
layout(binding = kImageEnergy, rgba32f) uniform writeonly image2D o_energy;                 // sum w nu, sum w (lights included), sum t^2 (with the stratum factor), 1 + material

struct List {
  uint items, points, groups_x, groups_y, groups_z, samples, visible, overflow;
};
layout(std430, binding = kBufferCounters) readonly buffer Counters { List b_lists[2]; };
layout(std430, binding = kBufferMeasuredPixels) readonly buffer Pixels { uint b_pixels[]; };  // every other word
uniform int u_list;

struct Result {
  vec2 energy;   // sum w nu, sum w
  float second;  // sum t^2
  vec2 drawn;    // number of shading's samples that one lobe sample and one list sample here represent; shading draws other shares of both
  vec2 strata;   // lobe samples and list samples that shading will draw
#if SHADOWED
  VisibilityPoint visibility;
  uint random;
#endif
#if SHADOWED == 2
  vec2 edges;  // sum w nu_L / distance of what is blocked, sum w of all
#endif
};

const int kSeenBandwidthCount = SEEN_BANDWIDTHS;  // lobe k has nu_rho = 2^(k - 1) cycles/rad: render/environment/environment_tables.h

/// The light's bandwidth around a direction: unfiltered, and filtered by a lobe of bandwidth nu_rho.
vec2 environment_bandwidth(vec3 d, float nu_rho) {
  ivec2 size = u_frame.bandwidth_size.xy;
  ivec2 p = clamp(ivec2(latlong_uv_from_direction(d) * vec2(size)), ivec2(0), size - 1);
  int first = (p.y * size.x + p.x) * (kSeenBandwidthCount + 1);
  float lobe = clamp(log2(nu_rho) + 1.0, 0.0, float(kSeenBandwidthCount));
  int k = min(int(lobe), kSeenBandwidthCount - 1);
  float broader = texelFetch(t_environment_bandwidth, first + k).x, narrower = texelFetch(t_environment_bandwidth, first + k + 1).x;
  return vec2(texelFetch(t_environment_bandwidth, first + kSeenBandwidthCount).x, mix(broader, narrower, lobe - float(k)));
}

float brdf_bandwidth(Point p, vec3 wi) {
#if MEASURED
  vec3 c = merl_coordinates(wi, p.wo);
  int h = clamp(int(c.x + 0.5), 0, 89), d = clamp(int(c.y + 0.5), 0, 89);
  return texelFetch(t_brdf_bandwidth, (p.slot * 90 + h) * 90 + d).x;
#else
  AnalyticLobes f = evaluate_analytic(p.analytic, wi, p.wo);
  float total = max(luminance(f.total), 1e-12);
  float rest = max(total - f.specular - f.coat, 0.0);
  GgxWidth width = base_width(p.analytic);
  float narrowest = min(width.x, width.y);
  return (f.specular * bandwidth_ggx(narrowest) + f.coat * bandwidth_ggx(p.analytic.coat_alpha) + rest * kBandwidthLambert) / total;
#endif
}

/// Bandwidth of a measured material's albedo over the elevation of the view, cycles/rad. The albedo multiplies the filtered light, so their
/// bandwidths add. A curve like 1 + cos(2 pi nu x) has |a'| / a and sqrt(|a''| / a) up to 2 pi nu.
float albedo_bandwidth(Point p) {
  if (p.slot < 0) return 0.0;
  const int kHalf = 2;  // entries to either side, because measured tables are noisy
  int i = int(latlong_atan2(p.wo.x, p.wo.z) * (float(kAlbedoEntries - 1) * 0.63661977) + 0.5);
  int middle = p.slot * kAlbedoEntries + clamp(i, kHalf, kAlbedoEntries - 1 - kHalf);
  float a = max(texelFetch(t_albedo, middle).x, 1e-6);
  float before = texelFetch(t_albedo, middle - kHalf).x / a, after = texelFetch(t_albedo, middle + kHalf).x / a;
  float step_rad = float(kHalf) * (1.5707963 / float(kAlbedoEntries - 1));
  return max(0.5 * abs(after - before), sqrt(abs(after - 2.0 + before))) / (2.0 * kPi * step_rad);
}

#if SHADOWED
uint hash(uint x);
vec2 unit_pair(uint x);
const float kEdgeNu = 2.3;        // of a step anywhere on the half sphere, for which one sample gives no position
const float kVisibilityNu = 4.6;  // mean |v1 - v2| in the middle of a step is 1/2: 2.3 cycles/rad
#endif

void on_sample(inout Result r, Point p, vec3 f, vec3 radiance, float weight, vec3 wi, vec3 world, float pdf, bool is_brdf, bool sun) {
  float t = luminance(f * radiance) * weight, stands_for = is_brdf ? r.drawn.x : r.drawn.y;
#if SKY_VARIANCE
  bool counts = !sun;  // the sun's samples do not belong to those whose number is predicted
#else
  const bool counts = true;
#endif
  float nu_r = brdf_bandwidth(p, wi);
  vec2 sky = environment_bandwidth(world, nu_r);
  float nu_l = sky.x, nu_seen = sky.y;
#if SHADOWED == 2
  // The edge of an occluder at distance d moves over the sky by 1 rad / d per metre, and the product of light and occlusion has no more than
  // the light's own bandwidth. Source: Durand et al. 2005, "A Frequency Analysis of Light Transport", Sec. 4.1 and 4.2.
  float distance_m = blocked_at(r.visibility, world_from_environment(world), 1e30);
  r.edges += stands_for * t * vec2(distance_m < 0.0 ? 0.0 : nu_l / max(distance_m, r.visibility.own_m), 1.0);
  nu_l += kEdgeNu;
  nu_seen += kEdgeNu;
  t *= distance_m < 0.0 ? 1.0 : 0.0;
#elif SHADOWED
  // The difference of two cells of the visibility map bounds its change around this direction: half a cycle over one cell, 0.22 rad.
  vec3 w = world_from_environment(world);
  r.random = hash(r.random + 0x9E3779B9u);
  vec2 cells = two_cells(r.visibility, w, unit_pair(r.random), unit_pair(hash(r.random)));
  float edge = kVisibilityNu * cells.y;
  nu_l += edge;
  nu_seen += edge;
  t *= cells.x;
#endif
  r.energy.x += stands_for * t * min(nu_seen, nu_r);
  r.energy.y += stands_for * t;
  // One of n low-discrepancy samples represents a stratum of size 1 / (n pdf); only the variation inside the stratum adds variance. A strategy's
  // own factor is mostly in its density, the other's is not. Strata of a measured lobe are stretched by 1 / cos at
  // grazing views. The factors come from `maquette_bench validate` (docs/tried.md).
  float stratum = inversesqrt(kPi * max((is_brdf ? r.strata.x : r.strata.y) * pdf, 1e-6));
#if MEASURED
  float of_lobe = (2.0 * nu_l + 0.5 * nu_r) / max(p.wo.z, 0.05);
#else
  float of_lobe = 2.0 * nu_l;
#endif
  float change = is_brdf ? of_lobe : nu_l + 2.0 * nu_r;
  float share = min(0.203 * change * stratum, 0.264);
  r.second += counts ? stands_for * t * t * share : 0.0;
}
#define VISIBILITY 0  // of the estimator: on_sample looks itself
#define ON_SAMPLE(f, radiance, weight, wi, world, pdf, is_brdf) \
  on_sample(result, p, f, radiance, weight, wi, world, pdf, is_brdf, luminance(radiance) * e.inverse_integral > kSunDensity)
#define HALVES (PREDICTION_SAMPLES / 2)
#define SAMPLE_GROUP 4
#define WEIGHED_AS_SHADED
#include "shading/integrate.glsl"
#if LIGHTS
#include "shading/lights.glsl"
const int kPredictedLights = 4;
/// Adds the lights' energy to the sums and returns the rest, the texel of the near image. In stored units, like all sums here.
vec4 add_lights(inout Result r, Point p, ivec2 pixel) {
  float unit = 1.0 / max(u_frame.environment.z, 1e-12);
  uint rotation = hash(uint(pixel.x) + (uint(pixel.y) << 16u) + hash(uint(u_frame.sampling.w)));
  vec4 near = vec4(0.0, 0.0, 0.0, 1.0);
  LightChoice choice = light_choice(p.position);
  const float share = 1.0 / float(kPredictedLights);
  int i = 0;
  do {
    LightDraw d = draw_light(p, choice, light_numbers(rotation, uint(i)), unit_pair(hash(rotation + uint(i))));
    float y = luminance(d.outgoing) * unit;
    if (y > 0.0) {
      float nu_r = brdf_bandwidth(p, d.wi);
      r.energy += share * y * vec2(nu_r, 1.0);
      near.xyz += share * vec3(y * d.wi.z * light_bandwidth(d.light, d.world, d.distance_m, nu_r), y, y * y);
    }
  } while (++i < kPredictedLights);
  // Unbiased variance of a few samples, scaled because shading draws fewer samples of lights than of the environment.
  int count = u_frame.sampling.y;
  near.z = max(near.z - near.y * near.y, 0.0) / (1.0 - share) * float(count) / float(light_sample_count(choice, count));
  return near;
}
#endif

void predict(ivec2 quad, ivec2 pixel) {
  Point p = load_point(pixel);
  Result result;
  result.energy = vec2(0.0);
  result.second = 0.0;
  float weighed = weighed_brdf_count(p, PREDICTION_SAMPLES, HALVES);
  vec2 as_shaded = vec2(weighed, float(PREDICTION_SAMPLES) - weighed);
  result.drawn = as_shaded / float(HALVES);
  result.strata = as_shaded * (float(u_frame.sampling.x) / float(PREDICTION_SAMPLES));
#if SHADOWED
  result.visibility = load_visibility(pixel, p.position, world_from_environment(p.n));
  result.random = uint(pixel.x) + (uint(pixel.y) << 16u);
#endif
#if SHADOWED == 2
  result.edges = vec2(0.0);
#endif
  integrate(p, pixel, 0u, PREDICTION_SAMPLES, result);
  result.energy *= p.occlusion;
  result.second *= p.occlusion * p.occlusion;
  // A change of the normal moves the mirror direction twice as far as the view's elevation, hence 0.5.
  result.energy.x += 0.5 * albedo_bandwidth(p) * result.energy.y;
#if SHADOWED || LIGHTS
  vec4 near = vec4(0.0);
#if SHADOWED == 2
  near.x += result.energy.y * result.edges.x / max(result.edges.y, 1e-20);
#elif SHADOWED
  ivec3 v = result.visibility.vertices;
  near.x += result.energy.y * dot(result.visibility.barycentric, vec3(texelFetch(t_visibility_bandwidth, v.x).x,
                                                                      texelFetch(t_visibility_bandwidth, v.y).x,
                                                                      texelFetch(t_visibility_bandwidth, v.z).x));
#endif
#if LIGHTS
  near += add_lights(result, p, pixel);
#endif
  imageStore(o_near, quad, near);
#endif
  imageStore(o_energy, quad, vec4(result.energy, result.second, float(p.material + 1)));
}

void main() {
  uint id = linear_id();
  if (id >= b_lists[u_list].items) return;
  uint packed_pixel = b_pixels[2u * id];
  ivec2 pixel = ivec2(packed_pixel & 65535u, packed_pixel >> 16u);
  predict(pixel / 2, pixel);
}
