// Opaque points that are reflected by rays through the octree: those with a narrow lobe, or of named parts. Needs shading/lobes.glsl.
#include "reflections/glossy_parts.glsl"

/// The part of a point's lobes that is traced.
struct MirrorLobe {
  vec3 albedo;       // 0: nothing
  vec3 direction;    // mean, local, any length
  float half_angle;  // rad from that direction; half of the lobe lies within
};

#if MEASURED
MirrorLobe measured_mirror(Point p, float widest) {
  LobeRow row = lobe_row(p);
  vec4 albedo = lobe_texel(row, 2);
  bool narrow = lobe_texel(row, 0).w <= widest;
  return MirrorLobe(narrow ? albedo.rgb * p.tint : vec3(0.0), lobe_texel(row, 3).xyz, albedo.w);
}
#endif

/// One ray represents base and coat; its direction is interpolated by their reflectances. Half of a GGX lobe has half vectors within atan(alpha).
MirrorLobe analytic_mirror(Point p, float widest) {
  AnalyticMaterial m = p.analytic;
  AnalyticMirrors mirrors = analytic_mirrors(m, p.wo.z);
  float widest_alpha = (widest + 0.5 / 255.0) * (widest + 0.5 / 255.0);  // the G-buffer has it in 8 bits
  vec3 base = mean_alpha(m) <= widest_alpha ? mirrors.base * (1.0 - mirrors.coat) : vec3(0.0);
  float coat = m.coat_alpha <= widest_alpha ? mirrors.coat : 0.0;
  float share = coat / max(coat + luminance(base), 1e-20);
  return MirrorLobe(base + vec3(coat), mix(lobe_direction(p.wo, mean_alpha(m)), lobe_direction(p.wo, m.coat_alpha), share),
                    2.0 * mix(mean_alpha(m), m.coat_alpha, share));
}

MirrorLobe mirror_lobe(Point p, int triangle) {
  float widest = widest_roughness(triangle);
#if MEASURED
  if (p.slot >= 0) return measured_mirror(p, widest);
#endif
  return analytic_mirror(p, widest);
}
bool mirrors(MirrorLobe lobe) { return lobe.albedo.r + lobe.albedo.g + lobe.albedo.b > 0.0; }
