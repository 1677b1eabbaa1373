// The estimator's sample loops, shared by shading and by the prediction. Direct light of the environment by BRDF and environment
// samples combined with the balance heuristic (Veach and Guibas 1995). The weights use Y(f) cos / albedo and Y(L) / integral as densities: both
// strategies use the same ones, so they sum to one whatever the samplers' own densities are, and no density has to be looked up.
//
// The including shader defines ON_SAMPLE(f, radiance, weight, wi, world, pdf, is_brdf): one sample's contribution to the
// sum is f * radiance * weight (1/sr, stored units), drawn with density pdf.
uint hash(uint x) {
  x = x * 747796405u + 2891336453u;
  x = ((x >> ((x >> 28u) + 4u)) ^ x) * 277803737u;
  return (x >> 22u) ^ x;
}
float unit_float(uint x) { return float(x >> 8u) * (1.0 / 16777216.0); }
vec2 unit_pair(uint x) { return vec2(float(x >> 16u), float(x & 65535u)) * (1.0 / 65536.0); }

/// Balance heuristic over the density: weight of a sample drawn from the BRDF, and of one from the environment's list. `nb`, `nl`: counts, the
/// second over the environment's integral.
float brdf_weight(float cosine, float f_hat, vec3 radiance, float nb, float nl, float pdf) {
  return cosine * f_hat / max((nb * f_hat + nl * luminance(radiance)) * pdf, 1e-30);
}
float light_weight(float cosine, float f_hat, float l, float inverse_integral, float nb, float nl, float pdf) {
  return cosine * l * inverse_integral / max((nb * f_hat + nl * l) * pdf, 1e-30);
}

#if defined(TURNED) && LOOKS_BACK
#define BEFORE
#include "turning/before.glsl"
#endif

/// How many of `count` samples are drawn from the BRDF; the rest come from the environment.
int brdf_sample_count(Point p, int count) {
  return u_frame.environment.w > 0.0 ? clamp(int(p.brdf_share * float(count) + 0.5), 1, count - 1) : count;
}

void integrate(Point p, ivec2 pixel, uint first_sample, int count, inout Result result) {
  float integral = u_frame.environment.w;
  int brdf_count = brdf_sample_count(p, count);
  int light_count = count - brdf_count;
  float inverse_integral = integral > 0.0 ? 1.0 / integral : 0.0;
  float nb = float(brdf_count), nl = float(light_count) * inverse_integral;

  // Additive recurrences on the golden ratios of dimension 2 (Roberts 2018), Cranley-Patterson rotated per pixel; the frame's first sample
  // index moves on while the picture converges.
  uint rotation = hash(uint(pixel.x) + (uint(pixel.y) << 16u) + hash(uint(u_frame.sampling.w)));
  uint block = first_sample / uint(count);
  uint first = block * uint(brdf_count);
  uint q1 = rotation + first * 0xC13FA9A9u, q2 = hash(rotation) + first * 0x91E10DA5u;
  uint q3 = hash(rotation ^ 0x68bc21ebu) + first_sample * 0xD1B54A33u;
  uint q4 = hash(rotation ^ 0x02e5be93u) + first_sample * 0xABC98388u;
  uint q5 = hash(rotation ^ 0x967a889bu) + first * 0x9E3779B9u;
  for (int i = 0; i < brdf_count; ++i) {
    q1 += 0xC13FA9A9u;
    q2 += 0x91E10DA5u;
    q3 += 0xD1B54A33u;
    q4 += 0xABC98388u;
    vec3 wi, f;
    float pdf, f_hat;
#if MEASURED
    g_brdf_slot = p.slot;
    BrdfSample s = sample_brdf(p.wo, vec2(unit_float(q1), unit_float(q2)));
    wi = s.wi;
    pdf = s.pdf;
    if (pdf <= 0.0) continue;
    f = measured_brdf(p.slot, wi, p.wo, unit_pair(q3)) * p.tint;
    f_hat = luminance(f) * wi.z * p.inverse_albedo;
#else
    q5 += 0x9E3779B9u;
    wi = sample_analytic(p.analytic, p.lobe_weights, p.wo, unit_float(q1), unit_float(q2), unit_float(q5));
    if (wi.z <= 0.0) continue;
    f = evaluate_analytic(p.analytic, wi, p.wo).total;
    pdf = analytic_pdf(p.analytic, p.lobe_weights, wi, p.wo);
    f_hat = pdf;
#endif
    vec3 world = from_local(p, wi);
    vec3 radiance = environment_stochastic(world, unit_pair(q4));
    float weight = brdf_weight(wi.z, f_hat, radiance, nb, nl, pdf);
#if VISIBILITY
    float open = visibility_of(result.visibility, world_from_environment(world), unit_pair(q3 ^ q4));
    weight *= open;
#endif
#ifdef BEFORE
    // The same direction, under the sky as it stood before: neither lobe nor shadow has changed.
    vec3 sky = environment_stochastic(stood_before(world), unit_pair(q4));
    result.before = f * sky * brdf_weight(wi.z, f_hat, sky, nb, nl, pdf);
#if VISIBILITY
    result.before *= open;
#endif
#endif
    ON_SAMPLE(f, radiance, weight, wi, world, pdf, true);
  }
  // The list in an order of the point's own: aligned runs of 2^k entries are digital nets, and numbers XORed with a mask run through them one
  // after the other from the first sample on (a mere offset begins amid one: 6 to 16 % more error on the Ferrari).
  uint light_first = block * uint(light_count), light_mask = hash(rotation ^ 0x5bd1e995u);
  int list_mask = u_frame.environment_size.w - 1;
  for (int i = 0; i < light_count; ++i) {
    int index = int(((light_first + uint(i)) ^ light_mask) & uint(list_mask));
    vec4 direction_pdf = texelFetch(t_light_samples, 2 * index);
    vec3 wi = to_local(p, direction_pdf.xyz);
    q3 += 0xD1B54A33u;
#ifdef BEFORE
    // The same light where it stood before.
    vec3 from = seen_before(direction_pdf.xyz), wi_before = to_local(p, from);
    if (max(wi.z, wi_before.z) <= 0.0) continue;
#else
    if (wi.z <= 0.0) continue;
#endif
    vec4 radiance_nu = texelFetch(t_light_samples, 2 * index + 1);
    vec3 radiance = radiance_nu.rgb;
#if MEASURED
    vec3 f = measured_brdf(p.slot, wi, p.wo, unit_pair(q3)) * p.tint;
    float f_hat = luminance(f) * wi.z * p.inverse_albedo;
#else
    vec3 f = evaluate_analytic(p.analytic, wi, p.wo).total;
    float f_hat = analytic_pdf(p.analytic, p.lobe_weights, wi, p.wo);
#endif
    float l = luminance(radiance);
    float weight = light_weight(wi.z, f_hat, l, inverse_integral, nb, nl, direction_pdf.w);
#if VISIBILITY
    vec2 dither = unit_pair(q3 ^ (q4 + uint(i) * 0x9E3779B9u));
    weight *= visibility_of(result.visibility, world_from_environment(direction_pdf.xyz), dither);
#endif
#ifdef BEFORE
    weight = wi.z > 0.0 ? weight : 0.0;
    LobeValue lobe = evaluate_lobe(p, wi_before, unit_pair(q3));
    float weight_before = light_weight(wi_before.z, lobe.f_hat, l, inverse_integral, nb, nl, direction_pdf.w);
#if VISIBILITY
    weight_before *= visibility_of(result.visibility, world_from_environment(from), dither);
#endif
    result.before = wi_before.z > 0.0 ? lobe.f * radiance * weight_before : vec3(0.0);
#endif
    ON_SAMPLE(f, radiance, weight, wi, direction_pdf.xyz, direction_pdf.w, false);
  }
}
