// The light that comes by way of other surfaces at every visible point, kept until it changes: baked per vertex, interpolated here, so it costs
// three fetches a point and no samples. Radiance is linear in the direction, and what a lobe makes of that is its albedo times the value in its mean
// direction, exactly.
layout(local_size_x = 64) in;
#include "shared/frame.glsl"
#ifndef REFLECTED
#include "shared/tiles.glsl"
#endif
#include "shared/constants.glsl"
#include "shared/latlong.glsl"
#include "shared/octahedral.glsl"
#include "shared/rgb9e5.glsl"
#include "shared/gbuffer.glsl"
#include "shared/material_table.glsl"
#include "shared/analytic.glsl"
#include "shared/merl.glsl"
#include "shading/point.glsl"
#include "shading/visibility.glsl"
#include "shared/indirect.glsl"
layout(binding = 45) uniform usamplerBuffer t_indirect;  // [side][vertex], shared/indirect.glsl
layout(binding = 44) uniform samplerBuffer t_lobes;      // [slot][64] two texels: albedo | mean direction in the frame of view and normal
#ifdef REFLECTED
layout(binding = 0, rgba32f) uniform image2D io_radiance;
#else
layout(binding = 0, rgba32f) uniform writeonly image2D o_indirect;
#endif
uniform int u_bias;
uniform int u_back;  // first entry of the backs, 0: only fronts are baked

IndirectLight load_indirect(VisibilityPoint v) {
  vec3 first = texelFetch(t_vertices, 4 * v.vertices.x + 1).xyz;
  int side = dot(first, v.normal) < 0.0 ? u_back : 0;
  IndirectLight sum;
  sum.mean = sum.red = sum.green = sum.blue = vec3(0.0);
  for (int k = 0; k < 3; ++k) {
    IndirectLight l = unpack_indirect(texelFetch(t_indirect, v.vertices[k] + side), u_bias);
    sum.mean += v.barycentric[k] * l.mean;
    sum.red += v.barycentric[k] * l.red;
    sum.green += v.barycentric[k] * l.green;
    sum.blue += v.barycentric[k] * l.blue;
  }
  if (dot(first, v.normal) < 0.0 && u_back == 0) sum.mean = sum.red = sum.green = sum.blue = vec3(0.0);
  return sum;
}

/// A local direction (any length) in the world.
vec3 to_world(Point p, vec3 w) { return world_from_environment(from_local(p, w)); }

vec3 reflect_measured(Point p, IndirectLight light) {
  float e = latlong_atan2(p.wo.x, p.wo.z) * (float(kAlbedoEntries - 1) * 0.63661977);
  int i = min(int(e), kAlbedoEntries - 2), row = 2 * (p.slot * kAlbedoEntries + i);
  vec3 albedo = mix(texelFetch(t_lobes, row).rgb, texelFetch(t_lobes, row + 2).rgb, e - float(i));
  vec3 direction = mix(texelFetch(t_lobes, row + 1).rgb, texelFetch(t_lobes, row + 3).rgb, e - float(i));
  // The table's azimuth 0 is the side of the view.
  return albedo * p.tint * indirect_radiance(light, to_world(p, direction));
}

vec3 reflect_analytic(Point p, IndirectLight light) {
  AnalyticMaterial m = p.analytic;
  float x = 1.0 - p.wo.z;
  float x5 = x * x * x * x * x;
  // Schlick's term, the largest reflectance held down by the roughness. Source: Lagarde 2011, "Adopting a physically based shading model".
  vec3 f = m.f0 + (max(vec3(m.f90 * (1.0 - sqrt(m.alpha))), m.f0) - m.f0) * x5;
  // A lobe looks between the mirror direction and, when it is as wide as the hemisphere, the Lambertian one.
  vec3 mirror = vec3(-p.wo.x, -p.wo.y, p.wo.z), lambert = vec3(0.0, 0.0, 2.0 / 3.0);
  vec3 result = m.diffuse * (1.0 - max(f.r, max(f.g, f.b))) * indirect_radiance(light, to_world(p, lambert));
  result += f * indirect_radiance(light, to_world(p, mix(mirror, lambert, m.alpha)));
  float coat = m.coat * (0.04 + 0.96 * x5);
  return result * (1.0 - coat) + coat * indirect_radiance(light, to_world(p, mix(mirror, lambert, m.coat_alpha)));
}

void main() {
#ifdef REFLECTED
  ivec2 pixel = ivec2(gl_WorkGroupID.xy) * 8 + ivec2(gl_LocalInvocationIndex & 7u, gl_LocalInvocationIndex >> 3);
  if (any(greaterThanEqual(pixel, u_frame.size.xy))) return;
#else
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
#endif
  if (!(texelFetch(t_depth, pixel, 0).x > 0.0)) return;
  Point p = load_point(pixel);
  IndirectLight light = load_indirect(load_visibility(pixel, p.position, world_from_environment(p.n)));
  vec3 reflected = vec3(0.0);
#if MEASURED
  if (p.slot >= 0) reflected = reflect_measured(p, light);
#endif
  if (p.slot < 0) reflected = reflect_analytic(p, light);
#ifdef REFLECTED
  vec4 radiance = imageLoad(io_radiance, pixel);
  imageStore(io_radiance, pixel, vec4(radiance.rgb + reflected, radiance.a));
#else
  imageStore(o_indirect, pixel, vec4(reflected, 0.0));
#endif
}
