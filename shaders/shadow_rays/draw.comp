// Rays from every visible point to what lights it: towards the sun, to one of the scene's lights, and to the sky, each
// with the light that it brings if nothing is in between. The host traces them (render/shadow_rays/shadow_pass.cpp).
// SEPARATE_SUN: the environment has a sun, which the samples of shading leave out. LIGHTS: shading has the scene's
// lights without shadows, and there are rays to them. SKY: to the sky too. MAPS: shading has the sky through visibility maps, else without shadows.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
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
#include "shadow_rays/sun_ray.glsl"
#if MAPS
#include "shading/visibility.glsl"
#else
layout(binding = kUnitTriangle) uniform usampler2D t_triangle;
#endif
layout(binding = kUnitSunSamples) uniform samplerBuffer t_sun_samples;  // two texels: direction, - | radiance over density, -
uniform int u_frame_number;
uniform int u_facing_sun;   // 1: to the sun alone, which is compact: points that face away have none
uniform ivec2 u_sun_list;  // entries, samples of a point that does not mirror the sun

/// As in render/shadow_rays/shadow_pass.cpp. Light is the product with the BRDF and the cosine, cd/m2; directions are octahedral, world.
struct PointRays {
  vec3 position;
  uint triangle;  // + 1; 0: no point
  vec3 sun;
  uint to_sun;
  vec3 lamp;
  uint to_lamp;
  vec3 sky;
  uint to_sky;
  float lamp_m;    // distance of the lamp
  float mapped;    // share of the sky's light that shading has
  uint pixel;      // x | y << 16
  uint base_color;  // as in the G-buffer
};
layout(std430, binding = kBufferPointRays) writeonly buffer Rays { PointRays b_rays[]; };

/// The lobe's and the list's sample of the sky: one of them stays, in proportion to its light.
struct Result {
  vec3 sum, kept, direction;
  float light, chance;
};
void consider(inout Result r, vec3 value, vec3 direction) {
  float l = luminance(value);
  if (!(l > 0.0)) return;
  r.light += l;
  float share = l / r.light;
  bool taken = r.chance < share;
  r.chance = taken ? r.chance / share : (r.chance - share) / max(1.0 - share, 1e-6);
  r.kept = taken ? value / l : r.kept;
  r.direction = taken ? direction : r.direction;
}
#define ON_SAMPLE(f, radiance, weight, wi, world, pdf, is_brdf) consider(result, f * radiance * weight, world)
#define SAMPLE_GROUP 2
#include "shading/integrate.glsl"
#if LIGHTS
#include "shading/lights.glsl"
#endif

uint pack_direction(vec3 d) { return packUnorm2x16(octahedral_from_direction(d)); }

#if SEPARATE_SUN
/// Samples of a lobe that is brighter somewhere in the sun than in the mean of a few directions, which every point has.
const int kMany = 64, kProbes = 4;

vec3 sun_value(Point p, uint at, vec2 xi) {
  vec3 wi = to_local(p, texelFetch(t_sun_samples, 2 * int(at)).xyz);
  if (wi.z <= 0.0) return vec3(0.0);
#if MEASURED
  BrdfLookup lookup = brdf_lookup(p.slot, wi, p.wo, xi);
  LobeTerms lobe = lobe_terms(p, wi, fetch_brdf(lookup), lookup.fraction);
#else
  LobeTerms lobe = lobe_terms(p, wi);
#endif
  if (lobe_finds_sun(lobe.f_hat)) return vec3(0.0);
  return lobe.f * texelFetch(t_sun_samples, 2 * int(at) + 1).rgb * wi.z;
}

void draw_sun(Point p, uint mask, inout PointRays rays) {
  float brightest = 0.0;
  vec3 light = vec3(0.0);
  int count = u_sun_list.y, drawn = 0;
  for (; drawn < count; ++drawn) {
    vec3 value = sun_value(p, (uint(drawn) ^ mask) & uint(u_sun_list.x - 1), unit_pair(hash(mask) + uint(drawn) * kStep3));
    brightest = max(brightest, luminance(value));
    light += value;
    if (drawn + 1 == kProbes && brightest * float(kProbes) > 2.0 * luminance(light)) count = kMany;
  }
  rays.sun = light * (u_frame.environment.z / float(count));
  uint at = sun_ray(mask, uint(u_frame_number), uint(u_sun_list.x));
  rays.to_sun = pack_direction(world_from_environment(texelFetch(t_sun_samples, 2 * int(at)).xyz));
}
#endif

#if SKY
void draw_sky(Point p, ivec2 pixel, uint mask, inout PointRays rays) {
  Result r;
  r.sum = r.kept = r.direction = vec3(0.0);
  r.light = 0.0;
  r.chance = unit_float(hash(mask ^ 0x7f4a7c15u) + uint(u_frame_number) * 0x9E3779B9u);
  integrate(p, pixel, 2u * uint(u_frame_number), 2, r);
  if (!(r.light > 0.0)) return;
  vec3 world = world_from_environment(r.direction);
  rays.sky = r.kept * (r.light * u_frame.environment.z);
  rays.to_sky = pack_direction(normalize(world));
  rays.mapped = p.occlusion;
#if MAPS
  VisibilityPoint v = load_visibility(pixel, p.position, world_from_environment(p.n));
  rays.mapped *= mean_visibility(v, world);
#endif
}
#endif

void main() {
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
  uint id = linear_id();
  uint triangle = texelFetch(t_triangle, pixel, 0).x;
  int material = int(texelFetch(t_surface, pixel, 0).z >> 16u);
  uint flags = material_words(material, 6).x;
  bool shown = texelFetch(t_depth, pixel, 0).x > 0.0 && (flags & kMaterialUnlit) == 0u;
  if (!shown) {
    b_rays[id].triangle = 0u;
    return;
  }
  if (((flags & kMaterialMeasured) != 0u) != (MEASURED == 1)) return;
#if SEPARATE_SUN
  if (u_facing_sun == 1) {
    vec3 normal = environment_from_world(unpack_surface(texelFetch(t_surface, pixel, 0)).normal);
    if (dot(normal, texelFetch(t_sun_samples, 0).xyz) < -kSunRadius) return;
  }
#endif
  Point p = load_point(pixel);
#if MEASURED
  g_brdf_slot = p.slot;
#endif
  PointRays rays;
  rays.position = p.position;
  rays.triangle = triangle;
  rays.sun = rays.lamp = rays.sky = vec3(0.0);
  rays.to_sun = rays.to_lamp = rays.to_sky = 0u;
  rays.lamp_m = rays.mapped = 0.0;
  rays.pixel = uint(pixel.x) | uint(pixel.y) << 16u;
  rays.base_color = texelFetch(t_surface, pixel, 0).y;
  uint mask = hash_pixel(uint(pixel.x), uint(pixel.y), uint(u_frame.sampling.w) ^ kSunSeed);
#if SEPARATE_SUN
  draw_sun(p, mask, rays);
#endif
#if LIGHTS
  LightChoice choice = light_choice(p.position);
  LightDraw lamp = draw_light(p, choice, light_numbers(mask, uint(u_frame_number)), unit_pair(hash(mask + uint(u_frame_number) * 0xD1B54A33u)));
  rays.lamp = lamp.outgoing;
  rays.to_lamp = pack_direction(lamp.world);
  rays.lamp_m = lamp.distance_m;
#endif
#if SKY
  draw_sky(p, pixel, mask, rays);
#endif
  b_rays[id] = rays;
}
