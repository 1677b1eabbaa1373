// glTF 2.0 metallic-roughness with clearcoat, specular, ior and sheen. Local frame z = normal; wi, wo unit.
// Source: glTF 2.0 specification, Appendix B (GGX, Smith height-correlated masking, Schlick), and the KHR_materials_*
// extension texts; visible-normal sampling: Heitz 2018, "Sampling the GGX Distribution of Visible Normals".
// Needs shared/luminance.glsl before it. Common subset of GLSL and C++ with GLM (render/math/shared_formulas.h).
// Differs: the diffuse lobe is scaled by (1 - F(h)) as in the specification; energy lost to multiple scattering is not compensated.

#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

// Lobes that no material has need not be compiled: a software device also runs branches that no invocation takes.
#ifndef ANALYTIC_SHEEN
#define ANALYTIC_SHEEN 1
#endif
#ifndef ANALYTIC_COAT
#define ANALYTIC_COAT 1
#endif

struct AnalyticMaterial {
  vec3 diffuse;      // albedo of the Lambert lobe
  vec3 f0;           // specular reflectance at normal incidence
  float f90;
  float alpha;       // GGX alpha = roughness^2
  float coat;        // clearcoat strength
  float coat_alpha;
  vec3 sheen;
  float sheen_alpha;
};

/// Smallest alpha that float arithmetic and the half-pixel grid of normals can carry: a lobe of 0.06 degrees.
const float kMinAlpha = 1.0e-3f;

MAQUETTE_FN AnalyticMaterial make_analytic(vec3 base_color, float metallic, float roughness, float ior, float specular,
                               vec3 specular_color, float coat, float coat_roughness, vec3 sheen,
                               float sheen_roughness) {
  AnalyticMaterial m;
  float r = (ior - 1.0f) / (ior + 1.0f);
  vec3 dielectric = min(specular_color * (r * r), vec3(1.0f)) * specular;
  m.diffuse = base_color * (1.0f - metallic);
  m.f0 = dielectric * (1.0f - metallic) + base_color * metallic;
  m.f90 = specular * (1.0f - metallic) + metallic;
  m.alpha = max(roughness * roughness, kMinAlpha);
  m.coat = coat;
  m.coat_alpha = max(coat_roughness * coat_roughness, kMinAlpha);
  m.sheen = sheen;
  m.sheen_alpha = max(sheen_roughness * sheen_roughness, 1.0e-2f);
  return m;
}

/// GGX density of half vectors; 1 - cos^2 is taken from the sine so that narrow lobes keep their digits.
MAQUETTE_FN float ggx_d(vec3 h, float alpha) {
  float s2 = h.x * h.x + h.y * h.y;
  float t = s2 + h.z * h.z * alpha * alpha;
  float q = alpha / max(t, 1.0e-20f);
  return q * q * kInvPi * (alpha > 0.0f ? 1.0f : 0.0f);
}

/// Smith's G2 / (4 cos_i cos_o), height-correlated.
MAQUETTE_FN float ggx_visibility(float cos_i, float cos_o, float alpha) {
  float a2 = alpha * alpha;
  float gi = cos_o * sqrt(cos_i * cos_i * (1.0f - a2) + a2);
  float go = cos_i * sqrt(cos_o * cos_o * (1.0f - a2) + a2);
  return 0.5f / max(gi + go, 1.0e-12f);
}

/// Smith's G1 of one direction.
MAQUETTE_FN float ggx_g1(float cosine, float alpha) {
  float a2 = alpha * alpha;
  return 2.0f * cosine / max(cosine + sqrt(cosine * cosine * (1.0f - a2) + a2), 1.0e-12f);
}

MAQUETTE_FN float schlick_weight(float cosine) {
  float x = clamp(1.0f - cosine, 0.0f, 1.0f);
  float x2 = x * x;
  return x2 * x2 * x;
}

/// Values of the lobes for one pair of directions.
struct AnalyticLobes {
  vec3 total;      // BRDF, 1/sr
  float specular;  // luminance of the base's GGX lobe, 1/sr
  float coat;      // luminance of the coat's lobe, 1/sr
};

MAQUETTE_FN AnalyticLobes evaluate_analytic(AnalyticMaterial m, vec3 wi, vec3 wo) {
  vec3 h = normalize(wi + wo);
  float cos_d = max(dot(wi, h), 0.0f);
  float w = schlick_weight(cos_d);
  vec3 fresnel = m.f0 + (vec3(m.f90) - m.f0) * w;
  float largest_fresnel = max(max(fresnel.x, fresnel.y), fresnel.z);
  vec3 specular = fresnel * (ggx_d(h, m.alpha) * ggx_visibility(wi.z, wo.z, m.alpha));
  AnalyticLobes r;
  r.total = m.diffuse * (kInvPi * (1.0f - largest_fresnel)) + specular;
#if ANALYTIC_SHEEN
  if (m.sheen.x + m.sheen.y + m.sheen.z > 0.0f) {
    // Charlie distribution with the cheap visibility term of KHR_materials_sheen.
    float sin_h = sqrt(max(h.x * h.x + h.y * h.y, 1.0e-8f));
    float inv = 1.0f / m.sheen_alpha;
    float d = (2.0f + inv) * pow(sin_h, inv) * 0.15915494309f;
    r.total = r.total + m.sheen * (d / (4.0f * max(wi.z + wo.z - wi.z * wo.z, 1.0e-4f)));
  }
#endif
  r.specular = luminance(specular);
  r.coat = 0.0f;
#if ANALYTIC_COAT
  if (m.coat > 0.0f) {
    float fc = m.coat * (0.04f + 0.96f * w);
    r.coat = fc * ggx_d(h, m.coat_alpha) * ggx_visibility(wi.z, wo.z, m.coat_alpha);
    r.total = r.total * (1.0f - fc) + vec3(r.coat);
    r.specular *= 1.0f - fc;
  }
#endif
  return r;
}

/// Probabilities of sampling the diffuse, base specular and coat lobes.
MAQUETTE_FN vec3 analytic_lobe_weights(AnalyticMaterial m, vec3 wo) {
  float w = schlick_weight(wo.z);
  float specular = luminance(m.f0) + (m.f90 - luminance(m.f0)) * w;
  float coat = m.coat * (0.04f + 0.96f * w);
  float diffuse = luminance(m.diffuse) + 0.5f * luminance(m.sheen);
  vec3 p = vec3(diffuse * (1.0f - coat), specular * (1.0f - coat), coat);
  float sum = p.x + p.y + p.z;
  return sum > 0.0f ? p / sum : vec3(1.0f, 0.0f, 0.0f);
}

/// Density over solid angle of wi when the half vector is drawn from the visible normals.
MAQUETTE_FN float ggx_visible_pdf(vec3 h, vec3 wo, float alpha) {
  return ggx_g1(wo.z, alpha) * ggx_d(h, alpha) / max(4.0f * wo.z, 1.0e-12f);
}

MAQUETTE_FN float analytic_pdf(AnalyticMaterial m, vec3 weights, vec3 wi, vec3 wo) {
  vec3 h = normalize(wi + wo);
  float pdf = weights.x * wi.z * kInvPi + weights.y * ggx_visible_pdf(h, wo, m.alpha);
#if ANALYTIC_COAT
  if (weights.z > 0.0f) pdf += weights.z * ggx_visible_pdf(h, wo, m.coat_alpha);
#endif
  return pdf;
}

/// Visible normal of a GGX surface for u in [0,1)^2. Source: Heitz 2018, listing 1.
MAQUETTE_FN vec3 sample_ggx_visible(vec3 wo, float alpha, float u1, float u2) {
  vec3 v = normalize(vec3(alpha * wo.x, alpha * wo.y, wo.z));
  float length2 = v.x * v.x + v.y * v.y;
  vec3 t1 = length2 > 1.0e-12f ? vec3(-v.y, v.x, 0.0f) * inversesqrt(length2) : vec3(1.0f, 0.0f, 0.0f);
  vec3 t2 = cross(v, t1);
  float r = sqrt(u1);
  float phi = 6.28318530718f * u2;
  float p1 = r * cos(phi);
  float p2 = r * sin(phi);
  float s = 0.5f * (1.0f + v.z);
  p2 = (1.0f - s) * sqrt(max(0.0f, 1.0f - p1 * p1)) + s * p2;
  vec3 n = t1 * p1 + t2 * p2 + v * sqrt(max(0.0f, 1.0f - p1 * p1 - p2 * p2));
  return normalize(vec3(alpha * n.x, alpha * n.y, max(n.z, 1.0e-6f)));
}

// How many of n samples (8 or more) each lobe gets: its share, rounded; at least one if the share is above 0.
MAQUETTE_FN ivec3 lobe_counts(vec3 weights, int n) {
  int coat = weights.z > 0.0f ? clamp(int(weights.z * float(n) + 0.5f), 1, n - 2) : 0;
  int specular = weights.y > 0.0f ? clamp(int(weights.y * float(n) + 0.5f), 1, n - 1 - coat) : 0;
  if (weights.x > 0.0f) return ivec3(n - specular - coat, specular, coat);
  return weights.y > 0.0f ? ivec3(0, n - coat, coat) : ivec3(0, 0, n);
}

// A direction of a lobe (0 base, 1 specular, 2 coat) for (u1, u2) in [0, 1)^2; directions below the horizon contribute nothing.
MAQUETTE_FN vec3 sample_analytic(AnalyticMaterial m, int lobe, vec3 wo, float u1, float u2) {
  if (lobe == 0) {
    float r = sqrt(u1);
    float phi = 6.28318530718f * u2;
    return vec3(r * cos(phi), r * sin(phi), sqrt(max(0.0f, 1.0f - u1)));
  }
  vec3 h = sample_ggx_visible(wo, lobe == 2 ? m.coat_alpha : m.alpha, u1, u2);
  return h * (2.0f * dot(wo, h)) - wo;
}
