// Directional albedos of analytic materials: what they reflect of constant light towards a viewer. As C++ in render/materials/analytic_albedo.h.
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

/// Of a GGX lobe of reflectance 1 (x), and of one whose reflectance is Schlick's weight, (1 - cosine)^5 (y). Least squares fits to quadrature, exact
/// for a mirror: within 0.03 where the cosine is over 0.1, 0.02 and 0.005 where it is over 0.5.
MAQUETTE_FN vec2 ggx_albedo(float cosine, float alpha) {
  float q = clamp(1.0f - cosine, 0.0f, 1.0f);
  float q5 = q * q * q * q * q;
  vec3 rough = vec3(alpha, alpha * sqrt(alpha), alpha * alpha);
  float all = 1.0f + dot(rough, vec3(0.994f, -3.727f, 2.026f)) + q * dot(rough, vec3(-1.864f, 3.785f, -1.609f)) +
              q5 * dot(rough, vec3(-2.367f, 7.874f, -5.218f));
  float weighted = q5 + q * dot(rough, vec3(0.222f, -0.444f, 0.226f)) + q5 * dot(rough, vec3(-4.613f, 5.052f, -1.383f)) +
                   q5 * q5 * q * q * dot(rough, vec3(-7.077f, 16.134f, -9.127f));
  return vec2(clamp(all, 0.0f, 1.0f), clamp(weighted, 0.0f, 1.0f));
}

/// Cosine-weighted mean of Schlick's weight at the half vector over all other directions; within 1e-4.
MAQUETTE_FN float mean_schlick_weight(float cosine) {
  return 0.02801f + cosine * (-0.07709f + cosine * (0.07444f - cosine * 0.02538f));
}

/// Of the lobes; those of the base below the coat. Without sheen.
struct AnalyticAlbedo {
  vec3 diffuse;
  vec3 mirror;
  float coat;
};
MAQUETTE_FN AnalyticAlbedo analytic_albedo(AnalyticMaterial m, float cosine) {
  vec3 f0 = base_f0(m, cosine);
  vec2 base = ggx_albedo(cosine, mean_alpha(m));
  vec3 lost = f0 + (vec3(m.f90) - f0) * mean_schlick_weight(cosine);
  vec2 coat = ggx_albedo(cosine, m.coat_alpha);
  AnalyticAlbedo a;
  a.coat = m.coat * (0.04f * coat.x + 0.96f * coat.y);
  a.diffuse = m.diffuse * ((1.0f - max(lost.x, max(lost.y, lost.z))) * (1.0f - a.coat));
  a.mirror = (f0 * base.x + (vec3(m.f90) - f0) * base.y) * (1.0f - a.coat);
  return a;
}
