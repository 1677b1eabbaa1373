// Prefiltered GGX and split sums, the way of most real-time viewers: radiance = (F0 A + F90 B) sky(p, roughness) + diffuse.
// Source: Karis 2013, "Real Shading in Unreal Engine 4". Measured materials use the GGX lobe fitted to them.
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
#include "shared/prefiltered.glsl"
layout(binding = kUnitLobeFits) uniform samplerBuffer t_fits;  // three texels a slot: diffuse, alpha | F0 | F90

const int kGgxLevels = 17;

/// Level r (kGgxLevels - 1) is filtered for alpha = r^2.
/// Rough lobes lean from the mirrored direction to the normal. Source: Lagarde and de Rousiers 2014, "Moving Frostbite to Physically
/// Based Rendering", Sec. 4.9.3.
vec3 lobe_direction(vec3 wo, float roughness) {
  float alpha = roughness * roughness, lean = (1.0 - alpha) * (sqrt(1.0 - alpha) + alpha);
  return mix(vec3(0.0, 0.0, 1.0), vec3(-wo.xy, wo.z), lean);
}
vec3 sky_towards(Point p, vec3 direction, float roughness) {
  return map_trilinear(1, kGgxLevels, roughness * float(kGgxLevels - 1), latlong_uv_from_direction(from_local(p, direction)));
}
vec3 sky(Point p, float roughness) { return sky_towards(p, lobe_direction(p.wo, roughness), roughness); }

vec3 shade(Point p) {
  float nv = p.wo.z;
  vec3 light = diffuse_light(p.n);
  if (p.slot >= 0) {
    vec4 diffuse_alpha = texelFetch(t_fits, 3 * p.slot);
    vec3 f0 = texelFetch(t_fits, 3 * p.slot + 1).rgb, f90 = texelFetch(t_fits, 3 * p.slot + 2).rgb;
    float roughness = sqrt(diffuse_alpha.w);
    vec2 split = reflectance(nv, roughness).xy;
    return p.tint * (diffuse_alpha.rgb * light + (f0 * split.x + f90 * split.y) * sky(p, roughness));
  }
  AnalyticReflectance r = analytic_reflectance(p.analytic, p.wo, sqrt(p.analytic.sheen_alpha));
  vec3 sum = r.diffuse * light + r.specular * sky(p, sqrt(mean_alpha(p.analytic)));
  if (r.coat > 0.0) {
    float roughness = sqrt(p.analytic.coat_alpha);
    sum += r.coat * sky_towards(p, from_coat(p.analytic, lobe_direction(coat_view(p.analytic, p.wo), roughness)), roughness);
  }
  return sum;
}
#include "shared/lookup.glsl"
