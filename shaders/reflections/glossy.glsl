// Opaque points that mirror by rays through the octree: those whose lobe is narrow enough, or that are named. Needs shading/lobes.glsl.
#include "reflections/glossy_parts.glsl"

/// What is traced of a point's lobes.
struct MirrorLobe {
  vec3 albedo;       // 0: nothing
  vec3 direction;    // mean, local, any length
  float half_angle;  // from there, rad, within which half of it lies
};

#if MEASURED
MirrorLobe measured_mirror(Point p, float widest) {
  LobeRow row = lobe_row(p);
  vec4 albedo = lobe_texel(row, 2);
  bool narrow = lobe_texel(row, 0).w <= widest;
  return MirrorLobe(narrow ? albedo.rgb * p.tint : vec3(0.0), lobe_texel(row, 3).xyz, albedo.w);
}
#endif

/// One ray stands for base and coat, between them by what they reflect. Half of a GGX lobe lies within half vectors of atan(alpha).
MirrorLobe analytic_mirror(Point p, float widest) {
  AnalyticMaterial m = p.analytic;
  AnalyticMirrors mirrors = analytic_mirrors(m, p.wo.z);
  float widest_alpha = (widest + 0.5 / 255.0) * (widest + 0.5 / 255.0);  // the G-buffer has it in 8 bits
  vec3 base = m.alpha <= widest_alpha ? mirrors.base * (1.0 - mirrors.coat) : vec3(0.0);
  float coat = m.coat_alpha <= widest_alpha ? mirrors.coat : 0.0;
  float share = coat / max(coat + luminance(base), 1e-20);
  return MirrorLobe(base + vec3(coat), mix(lobe_direction(p.wo, m.alpha), lobe_direction(p.wo, m.coat_alpha), share),
                    2.0 * mix(m.alpha, m.coat_alpha, share));
}

MirrorLobe mirror_lobe(Point p, int triangle) {
  float widest = widest_roughness(triangle);
#if MEASURED
  if (p.slot >= 0) return measured_mirror(p, widest);
#endif
  return analytic_mirror(p, widest);
}
bool mirrors(MirrorLobe lobe) { return lobe.albedo.r + lobe.albedo.g + lobe.albedo.b > 0.0; }
