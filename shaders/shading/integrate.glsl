// The estimator's sample loops, shared by shading and by the prediction. Direct light of the environment by BRDF and environment
// samples combined with the balance heuristic (Veach and Guibas 1995). The weights use Y(f) cos / albedo and Y(L) / integral as densities. Both
// strategies use the same two, so the weights sum to one whatever the samplers' own densities are, and no density has to be looked up.
//
// The including shader defines ON_SAMPLE(f, radiance, weight, wi, world, pdf, is_brdf): one sample's contribution to the
// sum is f * radiance * weight (1/sr, stored units), drawn with density pdf.
#include "shading/random.glsl"

/// Denominator of the weights, for strategies with `lobe` and `light` samples per unit of solid angle: their sum, for the balance heuristic. Towards
/// a sun one strategy gets all the weight (maximum heuristic): samples of the list lie so close together there that the lobe hardly varies among
/// them, while few lobe samples hit the sun. That is the list, unless the lobe is denser than the list inside the sun (`amid`). The density at the
/// direction itself would leave the dim nodes at a sun's edge to the lobe.
/// Source: Veach 1997, "Robust Monte Carlo Methods for Light Transport Simulation", Sec. 9.2.2.
float strategy_sum(float lobe, float light, float amid, bool is_brdf, bool sun) {
  float alone = (lobe >= max(light, amid)) == is_brdf ? (is_brdf ? lobe : light) : 1e30;
  return sun ? alone : lobe + light;
}

#if SEPARATE_SUN
// The list does not contain the sun's texels. rotation/sun.comp adds their light, except for lobes that are narrower than the sun.
uniform vec3 u_sun;  // luminance above which a texel is of the sun, 1 / solid angle of the sun, 1 / integral of the rest (0: black)

/// True for a lobe narrow enough to find the sun by its own samples. Depends only on the direction, so each light is counted once whatever the
/// sample counts are.
bool lobe_finds_sun(float f_hat) { return f_hat > 4.0 * u_sun.y; }
#endif

/// Weight of a sample drawn from the BRDF, and of one from the environment's list. `nb`, `nl`: counts, the second over the environment's integral;
/// `l`: luminance of the light.
float brdf_weight(float cosine, float f_hat, float l, float inverse_integral, float nb, float nl, float pdf) {
#if SEPARATE_SUN
  if (l > u_sun.x) nl = lobe_finds_sun(f_hat) ? 0.0 : 1e30;
  return cosine * f_hat / max((nb * f_hat + nl * l) * pdf, 1e-30);
#else
  return cosine * f_hat / max(strategy_sum(nb * f_hat, nl * l, nl * u_frame.quality.w, true, l * inverse_integral > kSunDensity) * pdf, 1e-30);
#endif
}
float light_weight(float cosine, float f_hat, float l, float inverse_integral, float nb, float nl, float pdf) {
#if SEPARATE_SUN
  return cosine * l * inverse_integral / max((nl * l + nb * f_hat) * pdf, 1e-30);
#else
  return cosine * l * inverse_integral / max(strategy_sum(nb * f_hat, nl * l, nl * u_frame.quality.w, false, l * inverse_integral > kSunDensity) * pdf, 1e-30);
#endif
}

/// How many of `count` samples are drawn from the BRDF; the rest come from the environment. Multiples of a group where there are enough, because a
/// partly filled group costs as much as a full one.
int brdf_sample_count(Point p, int count) {
  int group = count >= 8 ? 4 : 1;
  int wanted = int(p.brdf_share * float(count / group) + 0.5) * group;
  return u_frame.environment.w > 0.0 ? clamp(wanted, group, count - group) : count;
}

/// Number of BRDF samples for the weights. The prediction uses the shares of shading's items, because it draws its own few samples with
/// other shares.
float weighed_brdf_count(Point p, int count, int drawn) {
#ifdef WEIGHED_AS_SHADED
  int item = max(u_frame.sampling.y, 2);
  return float(brdf_sample_count(p, item) * count) / float(item);
#else
  return float(drawn);
#endif
}

/// What the samples of an item have in common.
struct Estimator {
  float nb, nl;  // counts, the second over the environment's integral
  float inverse_integral;
  uint q1, q2, q3, q4, q5;  // random numbers of the first sample
#if MEASURED
  int elevation;  // row of the importance table
#else
  uvec2 lobe_ends;   // first sample of the second and of the third lobe
  uvec3 lobe_first;  // offset from a sample's number to its index in the sequence of its lobe
#endif
};
// Additive recurrences (Roberts 2018): the golden ratios of dimension 2 for directions in a lobe, which matter most, and the third and fourth of
// dimension 4 for the node of the sky. Cranley-Patterson rotated per pixel.
const uint kStep1 = 0xC13FA9A9u, kStep2 = 0x91E10DA5u, kStep3 = 0xD1B54A33u, kStep4 = 0xA0F2EC75u, kStep5 = 0x89E18285u;

/// A direction drawn from the lobe, and the words of the BRDF and sky tables for its value.
struct LobeSample {
  vec3 wi, world;
  float pdf;  // 0: the sample contributes nothing
  int sky_index;
  uint sky;
#if MEASURED
  BrdfLookup lookup;
  uvec2 words;
#endif
};

/// The same for a sample of the environment's list.
struct SkySample {
  vec4 direction_pdf;
  vec3 radiance, wi;
#if MEASURED
  BrdfLookup lookup;
  uvec2 words;
#endif
};

/// Random numbers that choose one of the four sky nodes around lobe sample n.
vec2 node_choice(Estimator e, uint n) { return vec2(unit_float(e.q4 + n * kStep4), unit_float(e.q5 + n * kStep5)); }

struct LobeTerms {
  vec3 f;
  float f_hat;   // density for the balance heuristic
  float tinted;  // of AnalyticLobes; measured tables have the same share everywhere
};

#if MEASURED
/// The cell of half vectors that a sample falls in.
struct CellDraw {
  BrdfCellChoice choice;
  vec2 theta_cell, phi_cell;
};
CellDraw draw_cell(Estimator e, uint n) {
  BrdfCellChoice choice = brdf_cell_of(vec2(unit_float(e.q1 + n * kStep1), unit_float(e.q2 + n * kStep2)));
  return CellDraw(choice, fetch_theta_cell(e.elevation, choice.theta.k), fetch_phi_cell(e.elevation, choice.theta.k, choice.p));
}
LobeTerms lobe_terms(Point p, vec3 wi, uvec2 words, float fraction) {
  vec3 f = brdf_value(words, fraction) * p.tint;
  return LobeTerms(f, luminance(f) * wi.z * p.inverse_albedo, 0.0);
}
#else
LobeTerms lobe_terms(Point p, vec3 wi) {
  AnalyticLobes lobes = evaluate_analytic(p.analytic, wi, p.wo);
  return LobeTerms(lobes.total, analytic_pdf(p.analytic, p.lobe_weights, wi, p.wo), lobes.tinted);
}
#endif

#if defined(ROTATING) && REUSES_HISTORY
#define PREVIOUS_ROTATION
#include "rotation/before.glsl"
#endif

#if MEASURED
LobeSample draw_direction(Point p, Estimator e, uint n, CellDraw cell) {
  LobeSample s;
  BrdfSample drawn = brdf_sample_in_cell(p.wo, cell.choice, cell.theta_cell, cell.phi_cell);
  s.wi = drawn.wi;
  s.pdf = drawn.pdf;
  s.lookup = brdf_lookup(p.slot, s.wi, p.wo, unit_pair(e.q3 + n * kStep3));
#else
LobeSample draw_direction(Point p, Estimator e, uint n) {
  LobeSample s;
  int lobe = int(n >= e.lobe_ends.x) + int(n >= e.lobe_ends.y);
  uint at = n + (lobe == 0 ? e.lobe_first.x : lobe == 1 ? e.lobe_first.y : e.lobe_first.z);
  s.wi = sample_analytic(p.analytic, lobe, p.wo, unit_float(e.q1 + at * kStep1), unit_float(e.q2 + at * kStep2));
  s.pdf = max(s.wi.z, 0.0);
#endif
  s.world = from_local(p, s.wi);
  s.sky_index = environment_index(s.world, node_choice(e, n));
  return s;
}

void fetch_worth(inout LobeSample s) {
#if MEASURED
  s.words = fetch_brdf(s.lookup);
#endif
  s.sky = fetch_environment(s.sky_index);
}

void add_lobe_sample(Point p, Estimator e, uint n, LobeSample s, inout Result result) {
  if (s.pdf <= 0.0) return;
  vec3 wi = s.wi, world = s.world;
  float nb = e.nb, nl = e.nl;
#if MEASURED
  LobeTerms lobe = lobe_terms(p, wi, s.words, s.lookup.fraction);
  float pdf = s.pdf;
#else
  LobeTerms lobe = lobe_terms(p, wi);
  float pdf = lobe.f_hat;
#endif
  vec3 f = lobe.f;
  float f_hat = lobe.f_hat;
  vec3 radiance = environment_value(s.sky);
  float weight = brdf_weight(wi.z, f_hat, luminance(radiance), e.inverse_integral, nb, nl, pdf);
#if VISIBILITY
  float open = mean_visibility(result.visibility, world_from_environment(world));
  weight *= open;
#endif
#ifdef PREVIOUS_ROTATION
  // The same direction under the previous rotation: lobe and visibility are unchanged.
  vec3 sky = environment_value(fetch_environment(environment_index(previous_environment_direction(world), node_choice(e, n))));
  result.before = f * sky * brdf_weight(wi.z, f_hat, luminance(sky), e.inverse_integral, nb, nl, pdf);
#if VISIBILITY
  result.before *= open;
#endif
#endif
  ON_SAMPLE(f, radiance, weight, wi, world, pdf, true);
}

SkySample fetch_sky_sample(uint index) {
  SkySample s;
  s.direction_pdf = texelFetch(t_light_samples, 2 * int(index));
  s.radiance = texelFetch(t_light_samples, 2 * int(index) + 1).rgb;
  return s;
}

void find_sky_sample(Point p, Estimator e, uint n, inout SkySample s) {
  s.wi = to_local(p, s.direction_pdf.xyz);
#if MEASURED
  s.lookup = brdf_lookup(p.slot, s.wi, p.wo, unit_pair(e.q3 + n * kStep3));
#endif
}

void add_sky_sample(Point p, Estimator e, uint n, SkySample s, inout Result result) {
  vec3 wi = s.wi, light = s.direction_pdf.xyz, radiance = s.radiance;
  float nb = e.nb, nl = e.nl;
#ifdef PREVIOUS_ROTATION
  // The same light at its direction before the rotation.
  vec3 from = current_environment_direction(light), wi_before = to_local(p, from);
  if (max(wi.z, wi_before.z) <= 0.0) return;
#else
  if (wi.z <= 0.0) return;
#endif
#if MEASURED
  LobeTerms lobe = lobe_terms(p, wi, s.words, s.lookup.fraction);
#else
  LobeTerms lobe = lobe_terms(p, wi);
#endif
  vec3 f = lobe.f;
  float f_hat = lobe.f_hat;
  float l = luminance(radiance);
  float weight = light_weight(wi.z, f_hat, l, e.inverse_integral, nb, nl, s.direction_pdf.w);
#if VISIBILITY
  weight *= mean_visibility(result.visibility, world_from_environment(light));
#endif
#ifdef PREVIOUS_ROTATION
  weight = wi.z > 0.0 ? weight : 0.0;
  LobeTerms before = lobe_towards(p, wi_before, unit_pair(e.q3 + n * kStep3));
  float weight_before = light_weight(wi_before.z, before.f_hat, l, e.inverse_integral, nb, nl, s.direction_pdf.w);
#if VISIBILITY
  weight_before *= mean_visibility(result.visibility, world_from_environment(from));
#endif
  result.before = wi_before.z > 0.0 ? before.f * radiance * weight_before : vec3(0.0);
#endif
  ON_SAMPLE(f, radiance, weight, wi, light, s.direction_pdf.w, false);
}

// Samples are drawn, fetched and weighted in groups of SAMPLE_GROUP (2 or 4, defined by the includer), so that their memory accesses overlap. Macros
// instead of arrays, because some drivers keep arrays of structs in memory. A partly filled group costs as much as a full one, so items of few
// samples are faster with 2.
#if SAMPLE_GROUP == 4
#define FOR_GROUP(F) F(0) F(1) F(2) F(3)
#else
#define FOR_GROUP(F) F(0) F(1)
#endif
#define DRAW_CELL(k) CellDraw cell##k = draw_cell(e, n + uint(k));
#if MEASURED
#define DRAW_DIRECTION(k) LobeSample s##k = draw_direction(p, e, n + uint(k), cell##k);
#else
#define DRAW_DIRECTION(k) LobeSample s##k = draw_direction(p, e, n + uint(k));
#endif
#define FETCH_WORTH(k) fetch_worth(s##k);
#define ADD_LOBE(k) if (i + k < brdf_count) add_lobe_sample(p, e, n + uint(k), s##k, result);
#define FETCH_SKY(k) SkySample s##k = fetch_sky_sample(((light_first + n + uint(k)) ^ light_mask) & list_mask);
#define FIND_SKY(k) find_sky_sample(p, e, n + uint(k), s##k);
#define FETCH_LOBE(k) s##k.words = fetch_brdf(s##k.lookup);
#define ADD_SKY(k) if (i + k < light_count) add_sky_sample(p, e, n + uint(k), s##k, result);

// HALVES: the includer's count is a constant, and each strategy takes half of it.
void integrate(Point p, ivec2 pixel, uint first_sample, int count, inout Result result) {
#ifdef HALVES
  const int brdf_count = HALVES;
  int light_count = u_frame.environment.w > 0.0 ? HALVES : 0;
#else
  int brdf_count = brdf_sample_count(p, count);
  int light_count = count - brdf_count;
#endif
  Estimator e;
#if SEPARATE_SUN
  e.inverse_integral = u_sun.z;
#else
  e.inverse_integral = u_frame.environment.w > 0.0 ? 1.0 / u_frame.environment.w : 0.0;
#endif
  e.nb = weighed_brdf_count(p, count, brdf_count);
  e.nl = (float(count) - e.nb) * e.inverse_integral;
  // The frame's first sample index moves on while the picture converges.
  uint rotation = hash(uint(pixel.x) + (uint(pixel.y) << 16u) + hash(uint(u_frame.sampling.w)));
  uint block = first_sample / uint(count);
  uint first = block * uint(brdf_count) + 1u;
  e.q1 = rotation + first * kStep1;
  e.q2 = hash(rotation) + first * kStep2;
  e.q3 = hash(rotation ^ 0x68bc21ebu) + (first_sample + 1u) * kStep3;
  e.q4 = hash(rotation ^ 0x02e5be93u) + first * kStep4;
  e.q5 = hash(rotation ^ 0x967a889bu) + first * kStep5;
#if !MEASURED
  // Samples are assigned to the lobes in order. With few samples the shares are rounded at random;
  float share_to_samples = float(brdf_count), chance = unit_float(hash(rotation ^ 0x5f356495u) + block * 0x9E3779B9u);
  e.lobe_ends = uvec2(share_to_samples * vec2(p.lobe_weights.x, p.lobe_weights.x + p.lobe_weights.y) + chance);
  e.lobe_first = uvec3(0u);
#if !SEPARATE_SUN  // the sun's pass uses the weights unchanged
  // with 8 or more each lobe gets a fixed number, and its weight becomes that number over the total. Each lobe has its own sequence, which later
  // items continue.
  if (brdf_count >= 8) {
    uvec3 counts = uvec3(lobe_counts(p.lobe_weights, brdf_count));
    p.lobe_weights = vec3(counts) / float(brdf_count);
    e.lobe_ends = uvec2(counts.x, counts.x + counts.y);
    e.lobe_first = block * counts - uvec3(0u, e.lobe_ends) - block * uint(brdf_count);
  }
#endif
#endif
#if MEASURED
  g_brdf_slot = p.slot;
  e.elevation = brdf_elevation(p.wo);
#endif
  // Tested at the end: on software devices a loop that is tested at its beginning runs one more time, with all invocations inactive.
  int i = 0;
  do {
    uint n = uint(i);
#if MEASURED
    FOR_GROUP(DRAW_CELL)
#endif
    FOR_GROUP(DRAW_DIRECTION)
    FOR_GROUP(FETCH_WORTH)
    FOR_GROUP(ADD_LOBE)
    i += SAMPLE_GROUP;
  } while (i < brdf_count);
  // Each point reads the list in its own order. Aligned runs of 2^k entries are digital nets, and indices XORed with a mask pass through complete
  // runs from the first sample on (a plain offset starts inside a run: 6 to 16 % more error on the Ferrari).
  uint light_first = block * uint(light_count), light_mask = hash(rotation ^ 0x5bd1e995u), list_mask = uint(u_frame.environment_size.w - 1);
  e.q3 += uint(brdf_count) * kStep3;
  i = 0;
  do {
    uint n = uint(i);
    FOR_GROUP(FETCH_SKY)
    FOR_GROUP(FIND_SKY)
#if MEASURED
    FOR_GROUP(FETCH_LOBE)
#endif
    FOR_GROUP(ADD_SKY)
    i += SAMPLE_GROUP;
  } while (i < light_count);
}
