// Reflected indirect light at every visible point, kept until it changes. It is baked per vertex and interpolated here, so it costs
// three fetches a point and no samples. The radiance is linear in the direction, so a lobe reflects exactly its albedo times the radiance in its
// mean direction.
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
#include "shading/visibility.glsl"
#include "shading/lobes.glsl"
#include "shading/load_indirect.glsl"
#ifdef REFLECTED
layout(binding = kImageRadiance, rgba32f) uniform image2D io_radiance;
#else
layout(binding = kImageIndirect, rgba32f) uniform writeonly image2D o_indirect;
#endif
vec3 reflect_measured(Point p, IndirectLight light) {
  LobeRow row = lobe_row(p);
  return lobe_texel(row, 0).rgb * p.tint * indirect_radiance(light, to_world(p, lobe_texel(row, 1).rgb));
}

vec3 reflect_analytic(Point p, IndirectLight light) {
  AnalyticMaterial m = p.analytic;
  AnalyticAlbedo albedo = analytic_albedo(m, p.wo.z);
  return albedo.diffuse * indirect_radiance(light, to_world(p, vec3(0.0, 0.0, 2.0 / 3.0))) +
         albedo.mirror * indirect_radiance(light, to_world(p, lobe_direction(p.wo, mean_alpha(m)))) +
         albedo.coat * indirect_radiance(light, to_world(p, lobe_direction(p.wo, m.coat_alpha)));
}

void main() {
  ivec2 pixel = tile_point();
  if (pixel.x < 0) return;
  if (!(texelFetch(t_depth, pixel, 0).x > 0.0)) return;
  Point p = load_point(pixel);
  IndirectLight light = load_indirect(load_visibility(pixel, p.position, world_from_environment(p.n)));
  vec3 reflected = vec3(0.0);
#if MEASURED
  if (p.slot >= 0) reflected = reflect_measured(p, light);
#endif
  if (p.slot < 0) reflected = reflect_analytic(p, light);
  reflected *= p.occlusion;
#ifdef REFLECTED
  vec4 radiance = imageLoad(io_radiance, pixel);
  imageStore(io_radiance, pixel, vec4(radiance.rgb + reflected, radiance.a));
#else
  imageStore(o_indirect, pixel, vec4(reflected, 0.0));
#endif
}
