// Change of the reflected indirect light at glossy opaque points: the radiance that their mirrored rays hit replaces the light baked per vertex in
// the same lobes. Light of the sky is shaded already, by the share that the visibility map gives for the mean direction. What a ray meets is used for
// the remaining share only, so that no direction counts twice. Where rays correct the maps, all that exact rays meet counts: the mean over frames has
// as much of the scene as the lobe sees of it.
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
#include "shading/point.glsl"
#include "shading/lobes.glsl"
#include "reflections/glossy.glsl"
#if INDIRECT
#include "shading/visibility.glsl"
#include "shading/load_indirect.glsl"
#else
layout(binding = kUnitTriangle) uniform usampler2D t_triangle;
#endif
layout(binding = kUnitRayOrigin) uniform sampler2D t_ray_origin;        // m; w: depth, 0 for no ray
layout(binding = kUnitRayDirection) uniform sampler2D t_ray_direction;  // unit; w: material + 1
layout(binding = kUnitGlossyRadiance) uniform sampler2D t_met;          // cd/m2
layout(binding = kImageGlossy, rgba32f) uniform writeonly image2D o_glossy;
uniform int u_divisor;
uniform int u_sky_by_rays;  // 1: see above
uniform float u_lift_m;  // largest height above its surface at which a ray starts

/// A neighbour's ray belongs to the same surface if it starts this near its tangent plane, in points of the image of rays.
const float kSamePlane_px = 2.0;

/// Mean radiance that the rays around have hit, from this surface only; w: 0 where there is none.
vec4 met_around(ivec2 pixel, Point p, vec3 direction) {
  vec2 at = (vec2(pixel) + 0.5) / float(u_divisor) - 0.5;
  ivec2 low = ivec2(floor(at)), size = textureSize(t_met, 0);
  vec2 f = at - vec2(low);
  vec3 normal = world_from_environment(p.n);
  float near_m = kSamePlane_px * float(u_divisor) * pixel_width(p.distance_m);
  vec4 sum = vec4(0.0);
  for (int k = 0; k < 4; ++k) {
    ivec2 o = ivec2(k & 1, k >> 1), q = clamp(low + o, ivec2(0), size - 1);
    vec4 origin = texelFetch(t_ray_origin, q, 0), ray = texelFetch(t_ray_direction, q, 0);
    vec2 w = mix(1.0 - f, f, vec2(o));
    bool same = origin.w > 0.0 && int(ray.w) == p.material + 1 && abs(dot(origin.xyz - p.position, normal)) < near_m + u_lift_m;
    float alike = max(dot(ray.xyz, direction), 0.0);
    alike *= alike;
    alike *= alike;
    sum += same ? (w.x * w.y + 1e-4) * alike * alike * vec4(texelFetch(t_met, q, 0).rgb, 1.0) : vec4(0.0);
  }
  return sum.w > 1e-6 ? vec4(sum.rgb / sum.w, 1.0) : vec4(0.0);
}

vec3 change_of(ivec2 pixel) {
  Point p = load_point(pixel);
  MirrorLobe lobe = mirror_lobe(p, int(texelFetch(t_triangle, pixel, 0).x) - 1);
  if (!mirrors(lobe)) return vec3(0.0);
  vec3 mean = to_world(p, lobe.direction), direction = normalize(mean);
  vec4 met = met_around(pixel, p, direction);
  if (met.w == 0.0) return vec3(0.0);
#if INDIRECT
  VisibilityPoint v = load_visibility(pixel, p.position, world_from_environment(p.n));
  // Without the panes' transmittance: behind them is sky.
  float open = u_sky_by_rays != 0 ? 0.0 : interpolated_visibility(v, v.barycentric, direction);
  return lobe.albedo * p.occlusion * ((1.0 - open) * met.rgb - indirect_radiance(load_indirect(v), mean));
#else
  return lobe.albedo * p.occlusion * met.rgb;
#endif
}

void main() {
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
  imageStore(o_glossy, pixel, vec4(texelFetch(t_depth, pixel, 0).x > 0.0 ? change_of(pixel) : vec3(0.0), 0.0));
}
