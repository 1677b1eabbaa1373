// Spherical Gaussians of the half vector, one set for each channel, warped to light directions and convolved with the sky by lookups.
// Source: Wang et al. 2009, "All-Frequency Rendering of Dynamic, Spatially-Varying Reflectance", Sec. 4 (warp: sharpness over
// 4 |wo.h|, about the reflected direction). Differs: the cosine is a factor of the lobe (a Gaussian of sharpness 2.133) instead of a
// constant; a lobe's energy is its exact integral under a constant sky, from a table, instead of the warped Gaussian's; and the factor
// of Fresnel and shadowing depends on the view alone: it gives each elevation the albedo of the measured table.
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
layout(binding = kUnitLobeFits) uniform samplerBuffer t_fits;  // 71 a slot: diffuse | amplitude | sharpness | amplitude ... | 64 view factors
layout(binding = kUnitSgAlbedo) uniform sampler2D t_sg_albedo;  // x: sqrt(n.v), y: log2 of the sharpness; log of the lobe's albedo

const int kSgLobes = 3, kFitTexels = 1 + 2 * kSgLobes + kAlbedoEntries;
const float kTableSize = 64.0, kTableLog2Begin = -4.0, kTableLog2End = 27.0;
/// Sharpness of the Gaussian nearest to the clamped cosine. Source: Meder and Bruederl 2018, "Hemispherical Lighting Insights".
const float kCosineSharpness = 2.133;
/// The GGX density by three Gaussians: (1 + x)^-2 as a sum of a exp(-b x), x = 2 (1 - cos(theta_h)) / alpha^2. Least squares of the
/// cube roots over x in [0, 400] with both sums a and a / b kept at 1. Source: our own fit.
const float kGgxAmplitude[kSgLobes] = float[kSgLobes](0.950314, 0.0491552, 0.000513558);
const float kGgxDecay[kSgLobes] = float[kSgLobes](1.441385, 0.161879, 0.0138569);

float sg_albedo(float sharpness, float nv) {
  float row = (log2(sharpness) - kTableLog2Begin) * ((kTableSize - 1.0) / (kTableLog2End - kTableLog2Begin));
  return exp(textureLod(t_sg_albedo, vec2(sqrt(nv), (row + 0.5) / kTableSize), 0.0).x);
}

/// Product of a lobe of the half vector with the cosine: unit axis times sharpness. `wo`: around the lobe's normal, as the result.
vec3 lobe_axis(vec3 wo, float sharpness) {
  return vec3(-wo.xy, wo.z) * (sharpness / (4.0 * wo.z)) + vec3(0.0, 0.0, kCosineSharpness);
}
/// Mean radiance that a lobe with this axis sees, local.
vec3 light_about(Point p, vec3 axis) {
  float product = length(axis);
  return map_trilinear(1, map_count() - 1, log2(product) - 1.0, latlong_uv_from_direction(from_local(p, axis / product)));
}
vec3 sg_light(Point p, float sharpness) { return light_about(p, lobe_axis(p.wo, sharpness)); }

/// Mean radiance that a GGX lobe sees, of the base or of the coat.
vec3 ggx_light(Point p, float alpha, bool coat) {
  vec3 wo = coat ? coat_view(p.analytic, p.wo) : p.wo;
  vec3 sum = vec3(0.0);
  float energy = 0.0;
  for (int k = 0; k < kSgLobes; ++k) {
    float sharpness = 2.0 * kGgxDecay[k] / (alpha * alpha);
    float share = kGgxAmplitude[k] * sg_albedo(sharpness, wo.z);
    vec3 axis = lobe_axis(wo, sharpness);
    sum += share * light_about(p, coat ? from_coat(p.analytic, axis) : axis);
    energy += share;
  }
  return sum / energy;
}

vec3 shade(Point p) {
  float nv = p.wo.z;
  vec3 light = diffuse_light(p.n);
  if (p.slot >= 0) {
    int first = kFitTexels * p.slot;
    vec3 sum = vec3(0.0);
    for (int k = 0; k < kSgLobes; ++k) {
      vec3 amplitude = texelFetch(t_fits, first + 1 + 2 * k).rgb, sharpness = texelFetch(t_fits, first + 2 + 2 * k).rgb;
      for (int c = 0; c < 3; ++c)
        sum[c] += amplitude[c] * sg_albedo(sharpness[c], nv) * sg_light(p, sharpness[c])[c];
    }
    float elevation = latlong_atan2(p.wo.x, nv) * (float(kAlbedoEntries - 1) * 0.63661977);
    int i = min(int(elevation), kAlbedoEntries - 2), factors = first + 1 + 2 * kSgLobes;
    sum *= mix(texelFetch(t_fits, factors + i).rgb, texelFetch(t_fits, factors + i + 1).rgb, elevation - float(i));
    return p.tint * (sum + texelFetch(t_fits, first).rgb * light);
  }
  AnalyticReflectance r = analytic_reflectance(p.analytic, p.wo, sqrt(p.analytic.sheen_alpha));
  vec3 sum = r.diffuse * light + r.specular * ggx_light(p, mean_alpha(p.analytic), false);
  if (r.coat > 0.0) sum += r.coat * ggx_light(p, p.analytic.coat_alpha, true);
  return sum;
}
#include "shared/lookup.glsl"
