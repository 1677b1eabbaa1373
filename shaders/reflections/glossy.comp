// What the octree changes of the light that glossy opaque points send to the eye by way of other surfaces: what their mirrored rays met, in
// place of what the light baked by vertex made of the same lobes. The sky's share is shaded already: of the mean direction the masks let
// as much through as they say, and what the ray met stands for the rest alone, so that no direction counts twice.
layout(local_size_x = 64) in;
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/constants.glsl"
#include "shared/latlong.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/gbuffer.glsl"
#include "shared/material_table.glsl"
#include "shared/analytic.glsl"
#include "shared/merl.glsl"
#include "shading/point.glsl"
#include "shading/lobes.glsl"
#include "reflections/glossy.glsl"
#if INDIRECT
#include "shading/visibility.glsl"
#include "shading/load_indirect.glsl"
#else
layout(binding = 0) uniform usampler2D t_triangle;
#endif
layout(binding = 49) uniform sampler2D t_ray_origin;     // m; w: depth, 0 for no ray
layout(binding = 50) uniform sampler2D t_ray_direction;  // unit; w: material + 1
layout(binding = 53) uniform sampler2D t_met;            // cd/m2
layout(binding = 0, rgba32f) uniform writeonly image2D o_glossy;
uniform int u_divisor;
uniform float u_lift_m;  // as far above its surface a ray may start

/// Rays of neighbours are of the same surface while they start this near its tangent plane, in points of theirs.
const float kSamePlane_px = 2.0;

/// Mean of what the rays around have met, of this surface only; w: 0 where there is none.
vec4 met_around(ivec2 pixel, Point p, vec3 direction) {
  vec2 at = (vec2(pixel) + 0.5) / float(u_divisor) - 0.5;
  ivec2 low = ivec2(floor(at)), size = textureSize(t_met, 0);
  vec2 f = at - vec2(low);
  vec3 normal = world_from_environment(p.n);
  float near_m = kSamePlane_px * float(u_divisor) * u_frame.forward.w * p.distance_m;
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
  // Panes do not count: what is behind them is sky all the same.
  float open = mean_mask(v, v.barycentric, direction);
  return lobe.albedo * ((1.0 - open) * met.rgb - indirect_radiance(load_indirect(v), mean));
#else
  return lobe.albedo * met.rgb;
#endif
}

void main() {
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
  imageStore(o_glossy, pixel, vec4(texelFetch(t_depth, pixel, 0).x > 0.0 ? change_of(pixel) : vec3(0.0), 0.0));
}
