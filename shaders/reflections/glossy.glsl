// Opaque points that are reflected by rays: those with a narrow lobe, or of named parts. Needs shading/lobes.glsl.
#include "reflections/glossy_parts.glsl"

/// The part of a point's lobes that is traced.
struct MirrorLobe {
  vec3 albedo;       // 0: nothing
  vec3 direction;    // mean, local, any length
  float half_angle;  // rad from that direction; half of the lobe lies within
  float coat;        // share of the clear coat in the albedo
};

#if MEASURED
MirrorLobe measured_mirror(Point p, float widest) {
  LobeRow row = lobe_row(p);
  vec4 albedo = lobe_texel(row, 2);
  bool narrow = lobe_texel(row, 0).w <= widest;
  return MirrorLobe(narrow ? albedo.rgb * p.tint : vec3(0.0), lobe_texel(row, 3).xyz, albedo.w, 0.0);
}
#endif

/// One ray represents base and coat; its direction is interpolated by their reflectances. Half of a GGX lobe has half vectors within atan(alpha).
MirrorLobe analytic_mirror(Point p, float widest) {
  AnalyticMaterial m = p.analytic;
  AnalyticAlbedo albedo = analytic_albedo(m, p.wo.z);
  float widest_alpha = (widest + 0.5 / 255.0) * (widest + 0.5 / 255.0);  // the G-buffer has it in 8 bits
  vec3 base = mean_alpha(m) <= widest_alpha ? albedo.mirror : vec3(0.0);
  float coat = m.coat_alpha <= widest_alpha ? albedo.coat : 0.0;
  float share = coat / max(coat + luminance(base), 1e-20);
  return MirrorLobe(base + vec3(coat), mix(lobe_direction(p.wo, mean_alpha(m)), lobe_direction(p.wo, m.coat_alpha), share),
                    2.0 * mix(mean_alpha(m), m.coat_alpha, share), share);
}

MirrorLobe mirror_lobe(Point p, int triangle) {
  float widest = widest_roughness(triangle);
#if MEASURED
  if (p.slot >= 0) return measured_mirror(p, widest);
#endif
  return analytic_mirror(p, widest);
}
/// A direction of the lobe, local, for uniform numbers. Below the surface: the mean direction. A measured lobe is taken for the GGX lobe of its width.
vec3 sample_mirror(Point p, MirrorLobe lobe, vec3 u) {
  vec3 wi;
  if (p.slot >= 0) {
    vec3 h = sample_ggx_visible(p.wo, round_width(tan(0.5 * lobe.half_angle)), u.x, u.y);
    wi = h * (2.0 * dot(p.wo, h)) - p.wo;
  } else {
    wi = sample_analytic(p.analytic, u.z < lobe.coat ? 2 : 1, p.wo, u.x, u.y);
  }
  return wi.z > 0.0 ? wi : lobe.direction;
}
bool mirrors(MirrorLobe lobe) { return lobe.albedo.r + lobe.albedo.g + lobe.albedo.b > 0.0; }
