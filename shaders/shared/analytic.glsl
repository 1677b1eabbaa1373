// glTF 2.0 metallic-roughness with clearcoat, specular, ior, sheen, anisotropy and iridescence. Local frame z = normal, x = direction of the
// anisotropy; wi, wo unit.
// Source: glTF 2.0 specification, Appendix B (GGX, Smith height-correlated masking, Schlick), and the KHR_materials_*
// extension texts; visible-normal sampling: Heitz 2018, "Sampling the GGX Distribution of Visible Normals".
// Needs shared/luminance.glsl and shared/surface_geometry.glsl before it. Common subset of GLSL and C++ with GLM (render/math/shared_formulas.h).
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
#ifndef ANALYTIC_COAT_NORMAL
#define ANALYTIC_COAT_NORMAL 1
#endif
#ifndef ANALYTIC_ANISOTROPY
#define ANALYTIC_ANISOTROPY 1
#endif
#ifndef ANALYTIC_FILM
#define ANALYTIC_FILM 1
#endif
#if ANALYTIC_FILM
#include "shared/thin_film.glsl"
#endif

struct AnalyticMaterial {
  vec3 diffuse;      // albedo of the Lambert lobe
  float lambert;     // the same of a white base
  vec3 f0;           // specular reflectance at normal incidence
  float f90;
  float alpha;       // GGX alpha = roughness^2, along x
#if ANALYTIC_ANISOTROPY
  float alpha_y;     // along y
#endif
  float coat;        // clearcoat strength
  float coat_alpha;
#if ANALYTIC_COAT_NORMAL
  vec3 coat_normal;  // local
#endif
#if ANALYTIC_FILM
  float film;        // share of the base that a thin film covers
  float film_ior;
  float film_nm;     // thickness
#endif
  vec3 sheen;
  float sheen_alpha;
#if ANALYTIC_SHEEN
  vec4 sheen_albedo;  // of sheen_albedo()
#endif
};

/// Smallest alpha that float arithmetic and the half-pixel grid of normals can carry: a lobe of 0.06 degrees.
const float kMinAlpha = 1.0e-3f;

#if ANALYTIC_SHEEN
/// Whether a lobe of sheen is there at all.
MAQUETTE_FN bool has_sheen(AnalyticMaterial m) { return m.sheen.x + m.sheen.y + m.sheen.z > 0.0f; }

/// Coefficients of the sheen's albedo for a roughness of 0.1 to 1: its logarithm is a cubic of the cosine's root. Fitted to quadratures of the lobe
/// below; the albedo errs by at most 0.03 (SheenAlbedo.AgreesWithQuadrature).
MAQUETTE_FN vec4 sheen_albedo_coefficients(float roughness) {
  float root = sqrt(roughness);
  float inverse = 1.0f / roughness;
  return vec4(-8.74049f, 35.76781f, -61.44472f, 13.32194f) + vec4(9.04260f, -38.52659f, 68.28100f, -17.90755f) * root +
         vec4(1.44872f, -5.91365f, 7.43722f, -0.38405f) * inverse +
         vec4(-0.08785f, 0.41863f, -0.61878f, 0.06188f) * (inverse * inverse) +
         vec4(-1.72751f, 8.59043f, -17.64239f, 6.93758f) * (roughness * roughness);
}

/// Albedo of a white sheen seen at a cosine.
MAQUETTE_FN float sheen_albedo(vec4 coefficients, float cosine) {
  float s = sqrt(max(cosine, 0.0f));
  return exp(coefficients.x + s * (coefficients.y + s * (coefficients.z + s * coefficients.w)));
}

/// How much light of a direction the sheen leaves to what lies below. Source: KHR_materials_sheen, "Albedo-scaling technique".
MAQUETTE_FN float below_sheen(AnalyticMaterial m, float cosine) {
  float strongest = max(max(m.sheen.x, m.sheen.y), m.sheen.z);
  return clamp(1.0f - strongest * sheen_albedo(m.sheen_albedo, cosine), 0.0f, 1.0f);
}

/// Logarithm of the masking at a cosine below 1/2. Source: Conty Estevez and Kulla 2017, "Production Friendly Microfacet Sheen BRDF".
MAQUETTE_FN float sheen_masking(float cosine, float alpha) {
  float rough = 1.0f - (1.0f - alpha) * (1.0f - alpha);
  float a = 25.3245f + (21.5473f - 25.3245f) * rough;
  float b = 3.32435f + (3.82987f - 3.32435f) * rough;
  float c = 0.16801f + (0.19823f - 0.16801f) * rough;
  float d = -1.27393f + (-1.97760f + 1.27393f) * rough;
  float e = -4.85967f + (-4.32054f + 4.85967f) * rough;
  return a / (1.0f + b * pow(max(cosine, 1.0e-6f), c)) + d * cosine + e;
}
MAQUETTE_FN float sheen_lambda(float cosine, float alpha) {
  if (cosine < 0.5f) return exp(sheen_masking(cosine, alpha));
  return exp(2.0f * sheen_masking(0.5f, alpha) - sheen_masking(1.0f - cosine, alpha));
}

/// The lobe of a white sheen, 1/sr: "Charlie" distribution and visibility of KHR_materials_sheen.
MAQUETTE_FN float sheen_lobe(vec3 h, vec3 wi, vec3 wo, float alpha) {
  float sin_h = sqrt(max(h.x * h.x + h.y * h.y, 1.0e-8f));
  float inverse = 1.0f / alpha;
  float d = (2.0f + inverse) * pow(sin_h, inverse) * 0.15915494309f;
  float masked = 1.0f + sheen_lambda(wi.z, alpha) + sheen_lambda(wo.z, alpha);
  return d / (masked * max(4.0f * wi.z * wo.z, 1.0e-12f));
}
#endif

MAQUETTE_FN AnalyticMaterial make_analytic(vec3 base_color, float metallic, float roughness, float ior, float specular,
                               vec3 specular_color, float coat, float coat_roughness, vec3 sheen,
                               float sheen_roughness) {
  AnalyticMaterial m;
  float r = (ior - 1.0f) / (ior + 1.0f);
  vec3 dielectric = min(specular_color * (r * r), vec3(1.0f)) * specular;
  m.lambert = 1.0f - metallic;
  m.diffuse = base_color * m.lambert;
  m.f0 = dielectric * (1.0f - metallic) + base_color * metallic;
  m.f90 = specular * (1.0f - metallic) + metallic;
  m.alpha = max(roughness * roughness, kMinAlpha);
#if ANALYTIC_ANISOTROPY
  m.alpha_y = m.alpha;
#endif
#if ANALYTIC_COAT_NORMAL
  m.coat_normal = vec3(0.0f, 0.0f, 1.0f);
#endif
#if ANALYTIC_FILM
  m.film = 0.0f;
  m.film_ior = 1.3f;
  m.film_nm = 0.0f;
#endif
  m.coat = coat;
  m.coat_alpha = max(coat_roughness * coat_roughness, kMinAlpha);
  m.sheen = sheen;
  m.sheen_alpha = max(sheen_roughness * sheen_roughness, 1.0e-2f);
#if ANALYTIC_SHEEN
  m.sheen_albedo = vec4(0.0f);
  if (has_sheen(m)) m.sheen_albedo = sheen_albedo_coefficients(sqrt(m.sheen_alpha));
#endif
  return m;
}

#if ANALYTIC_ANISOTROPY
/// Source: KHR_materials_anisotropy: along the direction the roughness grows to 1 with the square of the strength.
MAQUETTE_FN AnalyticMaterial with_anisotropy(AnalyticMaterial m, float strength) {
  m.alpha = m.alpha + (1.0f - m.alpha) * strength * strength;
  return m;
}
#endif

/// Widths of a GGX lobe along x and y.
struct GgxWidth {
  float x;
  float y;
};
MAQUETTE_FN GgxWidth base_width(AnalyticMaterial m) {
  GgxWidth w;
  w.x = m.alpha;
#if ANALYTIC_ANISOTROPY
  w.y = m.alpha_y;
#else
  w.y = m.alpha;
#endif
  return w;
}
/// Width of the round lobe nearest to the base's.
MAQUETTE_FN float mean_alpha(AnalyticMaterial m) {
  GgxWidth w = base_width(m);
  return sqrt(w.x * w.y);
}
MAQUETTE_FN GgxWidth round_width(float alpha) {
  GgxWidth w;
  w.x = alpha;
  w.y = alpha;
  return w;
}

/// Coordinates of a direction around `normal`; the direction itself where the coat has no normal of its own.
MAQUETTE_FN vec3 around_coat(AnalyticMaterial m, vec3 w) {
#if ANALYTIC_COAT_NORMAL
  if (m.coat_normal.z >= 1.0f) return w;
  TangentBasis basis = tangent_basis(m.coat_normal);
  return vec3(dot(basis.t, w), dot(basis.b, w), dot(m.coat_normal, w));
#else
  return w;
#endif
}
MAQUETTE_FN vec3 from_coat(AnalyticMaterial m, vec3 w) {
#if ANALYTIC_COAT_NORMAL
  if (m.coat_normal.z >= 1.0f) return w;
  TangentBasis basis = tangent_basis(m.coat_normal);
  return basis.t * w.x + basis.b * w.y + m.coat_normal * w.z;
#else
  return w;
#endif
}

/// GGX density of half vectors; 1 - cos^2 is taken from the sine so that narrow lobes keep their digits.
MAQUETTE_FN float ggx_d(vec3 h, GgxWidth alpha) {
  float ax = max(alpha.x, 1.0e-6f);
  float ay = max(alpha.y, 1.0e-6f);
  float x = h.x / ax;
  float y = h.y / ay;
  float t = x * x + y * y + h.z * h.z;
  return kInvPi / max(ax * ay * t * t, 1.0e-20f);
}

/// Length of a direction in the space where the lobe is a hemisphere.
MAQUETTE_FN float ggx_stretched(vec3 w, GgxWidth alpha) {
  float x = alpha.x * w.x;
  float y = alpha.y * w.y;
  return sqrt(x * x + y * y + w.z * w.z);
}

/// Smith's G2 / (4 cos_i cos_o), height-correlated.
MAQUETTE_FN float ggx_visibility(vec3 wi, vec3 wo, GgxWidth alpha) {
  return 0.5f / max(wo.z * ggx_stretched(wi, alpha) + wi.z * ggx_stretched(wo, alpha), 1.0e-12f);
}

/// Smith's G1 of one direction.
MAQUETTE_FN float ggx_g1(vec3 w, GgxWidth alpha) {
  return 2.0f * w.z / max(w.z + ggx_stretched(w, alpha), 1.0e-12f);
}

MAQUETTE_FN float schlick_weight(float cosine) {
  float x = clamp(1.0f - cosine, 0.0f, 1.0f);
  float x2 = x * x;
  return x2 * x2 * x;
}

/// Reflectance of the base at an angle of incidence.
MAQUETTE_FN vec3 base_fresnel(AnalyticMaterial m, float cosine) {
  vec3 fresnel = m.f0 + (vec3(m.f90) - m.f0) * schlick_weight(cosine);
#if ANALYTIC_FILM
  if (m.film > 0.0f) fresnel = fresnel + (thin_film_fresnel(cosine, m.film_ior, m.film_nm, m.f0) - fresnel) * m.film;
#endif
  return fresnel;
}

/// Reflectance at normal incidence for the formulas of Schlick: with a film the one that has its reflectance at this angle.
MAQUETTE_FN vec3 base_f0(AnalyticMaterial m, float cosine) {
#if ANALYTIC_FILM
  if (m.film > 0.0f) {
    float w = min(schlick_weight(cosine), 0.99f);
    return clamp((base_fresnel(m, cosine) - vec3(m.f90 * w)) / (1.0f - w), vec3(0.0f), vec3(1.0f));
  }
#endif
  return m.f0;
}

/// Values of the lobes for one pair of directions.
struct AnalyticLobes {
  vec3 total;      // BRDF, 1/sr
  float specular;  // luminance of the base's GGX lobe, 1/sr
  float coat;      // luminance of the coat's lobe, 1/sr
  float tinted;    // what the base colour scales, for a white one, 1/sr
};

#if ANALYTIC_COAT
/// The coat's lobe, without its Fresnel term, over the cosine of the base's normal.
MAQUETTE_FN float coat_lobe(AnalyticMaterial m, vec3 h, vec3 wi, vec3 wo) {
  GgxWidth alpha = round_width(m.coat_alpha);
#if ANALYTIC_COAT_NORMAL
  vec3 ci = around_coat(m, wi);
  vec3 co = around_coat(m, wo);
  if (!(ci.z > 0.0f && co.z > 0.0f)) return 0.0f;
  float ratio = ci.z == wi.z ? 1.0f : ci.z / max(wi.z, 1.0e-4f);
  return ggx_d(around_coat(m, h), alpha) * ggx_visibility(ci, co, alpha) * ratio;
#else
  return ggx_d(h, alpha) * ggx_visibility(wi, wo, alpha);
#endif
}
#endif

MAQUETTE_FN AnalyticLobes evaluate_analytic(AnalyticMaterial m, vec3 wi, vec3 wo) {
  vec3 h = normalize(wi + wo);
  float cos_d = max(dot(wi, h), 0.0f);
  vec3 fresnel = base_fresnel(m, cos_d);
  float largest_fresnel = max(max(fresnel.x, fresnel.y), fresnel.z);
  GgxWidth alpha = base_width(m);
  float facets = ggx_d(h, alpha) * ggx_visibility(wi, wo, alpha);
  vec3 specular = fresnel * facets;
  AnalyticLobes r;
  r.tinted = m.lambert * (kInvPi * (1.0f - largest_fresnel)) + (1.0f - m.lambert) * (1.0f - schlick_weight(cos_d)) * facets;
  r.total = m.diffuse * (kInvPi * (1.0f - largest_fresnel)) + specular;
  r.specular = luminance(specular);
#if ANALYTIC_SHEEN
  if (has_sheen(m)) {
    float below = min(below_sheen(m, wi.z), below_sheen(m, wo.z));
    r.total = r.total * below + m.sheen * sheen_lobe(h, wi, wo, m.sheen_alpha);
    r.specular *= below;
    r.tinted *= below;
  }
#endif
  r.coat = 0.0f;
#if ANALYTIC_COAT
  if (m.coat > 0.0f) {
    float fc = m.coat * (0.04f + 0.96f * schlick_weight(cos_d));
    r.coat = fc * coat_lobe(m, h, wi, wo);
    r.total = r.total * (1.0f - fc) + vec3(r.coat);
    r.specular *= 1.0f - fc;
    r.tinted *= 1.0f - fc;
  }
#endif
  return r;
}

/// Probabilities of sampling the diffuse, base specular and coat lobes.
MAQUETTE_FN vec3 analytic_lobe_weights(AnalyticMaterial m, vec3 wo) {
  float specular = luminance(base_fresnel(m, wo.z));
  float coat = m.coat * (0.04f + 0.96f * schlick_weight(max(around_coat(m, wo).z, 0.0f)));
  float diffuse = luminance(m.diffuse);
#if ANALYTIC_SHEEN
  if (has_sheen(m)) {
    float below = below_sheen(m, wo.z);
    specular *= below;
    diffuse = diffuse * below + 0.5f * luminance(m.sheen);
  }
#endif
  vec3 p = vec3(diffuse * (1.0f - coat), specular * (1.0f - coat), coat);
  float sum = p.x + p.y + p.z;
  return sum > 0.0f ? p / sum : vec3(1.0f, 0.0f, 0.0f);
}

/// Density over solid angle of wi when the half vector is drawn from the visible normals.
MAQUETTE_FN float ggx_visible_pdf(vec3 h, vec3 wo, GgxWidth alpha) {
  return ggx_g1(wo, alpha) * ggx_d(h, alpha) / max(4.0f * wo.z, 1.0e-12f);
}

/// A view below the coat's horizon, as its normals may have it, is taken at the horizon.
MAQUETTE_FN vec3 visible_from_coat(vec3 wo) {
#if ANALYTIC_COAT_NORMAL
  return normalize(vec3(wo.x, wo.y, max(wo.z, 1.0e-3f)));
#else
  return wo;
#endif
}

MAQUETTE_FN float analytic_pdf(AnalyticMaterial m, vec3 weights, vec3 wi, vec3 wo) {
  vec3 h = normalize(wi + wo);
  float pdf = weights.x * wi.z * kInvPi + weights.y * ggx_visible_pdf(h, wo, base_width(m));
#if ANALYTIC_COAT
  if (weights.z > 0.0f) {
    vec3 seen = visible_from_coat(around_coat(m, wo));
    vec3 half_vector = around_coat(m, h);
    if (half_vector.z > 0.0f) pdf += weights.z * ggx_visible_pdf(half_vector, seen, round_width(m.coat_alpha));
  }
#endif
  return pdf;
}

/// Visible normal of a GGX surface for u in [0,1)^2. Source: Heitz 2018, listing 1.
MAQUETTE_FN vec3 sample_ggx_visible(vec3 wo, GgxWidth alpha, float u1, float u2) {
  vec3 v = normalize(vec3(alpha.x * wo.x, alpha.y * wo.y, wo.z));
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
  return normalize(vec3(alpha.x * n.x, alpha.y * n.y, max(n.z, 1.0e-6f)));
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
#if ANALYTIC_COAT_NORMAL
  if (lobe == 2) {
    vec3 seen = visible_from_coat(around_coat(m, wo));
    vec3 facet = sample_ggx_visible(seen, round_width(m.coat_alpha), u1, u2);
    facet = from_coat(m, facet);
    return facet * (2.0f * dot(wo, facet)) - wo;
  }
#endif
  GgxWidth alpha = base_width(m);
  if (lobe == 2) alpha = round_width(m.coat_alpha);
  vec3 h = sample_ggx_visible(wo, alpha, u1, u2);
  return h * (2.0f * dot(wo, h)) - wo;
}
