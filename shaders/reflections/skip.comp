// Finds mirrored rays that need not be traced, because their contribution is invisible against the light transmitted by the pane.
layout(local_size_x = 64) in;
#include "shared/bindings.glsl"
#include "shared/frame.glsl"
#include "shared/tiles.glsl"
#include "shared/fresnel.glsl"
#include "shared/luminance.glsl"
layout(binding = kUnitPane) uniform usampler2D t_pane;
layout(binding = kImageRayOrigin, rgba32f) uniform image2D io_origin;
layout(binding = kImageRayDirection, rgba32f) uniform image2D io_direction;
layout(binding = kUnitReflectorParts) uniform usamplerBuffer t_parts;  // [triangle of the reflectors] part
layout(binding = kUnitPartBounds) uniform samplerBuffer t_bounds;      // [part] the brightest small thing that it may mirror, cd/m2
layout(binding = kUnitProbes) uniform sampler2D t_probes;              // the reflected picture of few rays, cd/m2
layout(binding = kUnitProbeDirections) uniform sampler2D t_probe_directions;  // w: reflector + 1
layout(binding = kUnitCover) uniform sampler2D t_cover;    // share of the opaque picture that comes through at least
layout(binding = kUnitOpaque) uniform sampler2D t_opaque;  // the opaque picture, on the whole grid
layout(std430, binding = kBufferSkipCounters) buffer SkipCounters { uint b_followed, b_skipped; };
uniform int u_part_offset[16];  // of a reflector: added to a triangle's number
uniform vec3 u_optics[16];      // refractive index, largest internal transmittance, 1 for a pane
uniform float u_contrast;
uniform int u_divisor;
uniform int u_spacing;  // of the probes, pixels

/// Least luminance of the opaque picture among the points that the pixel is interpolated to.
float least_behind(ivec2 pixel) {
  ivec2 size = textureSize(t_opaque, 0);
  float least = 1e30;
  int side = u_divisor > 1 ? 4 : 1;
  for (int k = 0; k < side * side; ++k) {
    ivec2 o = u_divisor > 1 ? (ivec2(k & 3, k >> 2) * (2 * u_divisor - 1)) / 3 - u_divisor / 2 : ivec2(0);
    vec3 c = texelFetch(t_opaque, clamp(pixel * u_divisor + o, ivec2(0), size - 1), 0).rgb;
    least = min(least, luminance(c));
  }
  return least;
}

/// Radiance that the probes around show in a pane: rgb interpolated; w the brightest channel of nine probes. Below 0 where one of them shows
/// another reflector or none.
vec4 probed(ivec2 pixel, float reflector) {
  ivec2 size = textureSize(t_probes, 0);
  vec2 at = vec2(pixel - u_spacing / 2) / float(u_spacing) + 0.5;
  ivec2 middle = ivec2(at);
  vec4 sum = vec4(0.0);
  float most = 0.0;
  for (int k = 0; k < 9; ++k) {
    ivec2 p = middle + ivec2(k % 3, k / 3) - 1;
    if (any(lessThan(p, ivec2(0))) || any(greaterThanEqual(p, size))) continue;
    if (texelFetch(t_probe_directions, p, 0).w != reflector) return vec4(-1.0);
    vec3 c = texelFetch(t_probes, p, 0).rgb;
    most = max(most, max(c.r, max(c.g, c.b)));
    vec2 w = max(1.0 - abs(vec2(p) + 0.5 - at), 0.0);
    sum += w.x * w.y * vec4(c, 1.0);
  }
  return vec4(sum.rgb / max(sum.w, 1e-6), most);
}

/// Interpolated radiance of the probes for a ray that need not be traced, because its contribution is invisible against the transmitted
/// light; else below 0.
/// Source: Mueller et al. 2007, "Towards predictive virtual prototyping", Sec. 11.3.3: at most 5 % of the transmitted light.
/// Differs: exact Fresnel reflectance; the bound is twice the brightest probe around, or more where a part of the pane may show something small
/// and bright (render/reflections/mirrored_bound.h); saturation of the screen is not used, because the user sets the exposure.
vec3 unseen_radiance(ivec2 pixel, int triangle, float reflector, float cosine) {
  int number = int(reflector) - 1;
  vec4 probe = u_optics[number].z < 1.0 ? vec4(-1.0) : probed(pixel, reflector);
  if (probe.w < 0.0) return vec3(-1.0);
  float most = max(2.0 * probe.w, texelFetch(t_bounds, int(texelFetch(t_parts, triangle + u_part_offset[number]).x)).x);
  float mirrored = fresnel_pane(cosine, u_optics[number].x, u_optics[number].y).x * most;
  return mirrored <= u_contrast * texelFetch(t_cover, pixel, 0).x * least_behind(pixel) ? probe.rgb : vec3(-1.0);
}

void main() {
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
  vec4 direction = imageLoad(io_direction, pixel);
  if (direction.w <= 0.0) return;
  // The normal is halfway between the mirrored ray and the view direction.
  vec3 incident = normalize(view_ray(pixel));
  float cosine = sqrt(max(0.5 - 0.5 * dot(incident, direction.xyz), 0.0));
  vec3 unseen = unseen_radiance(pixel, int(texelFetch(t_pane, pixel, 0).x) - 1, direction.w, cosine);
  atomicAdd(b_followed, unseen.x < 0.0 ? 1u : 0u);
  if (unseen.x < 0.0) return;
  atomicAdd(b_skipped, 1u);
  imageStore(io_origin, pixel, vec4(unseen, imageLoad(io_origin, pixel).w));
  imageStore(io_direction, pixel, vec4(direction.xyz, -direction.w));
}
