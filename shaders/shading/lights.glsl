// Direct light of the scene's lights by sampling. A sample's light is selected by its possible contribution to the point. Only rays shadow it:
// baked visibility is that of the distant sky, not of a lamp nearby. environment_scale does not affect lights.
#include "shared/bindings.glsl"
#include "shared/lights.glsl"
layout(binding = kUnitLights) uniform samplerBuffer t_lights;  // render/lights/light_buffers.h

/// A sample of an emissive triangle is clamped to this many times the triangle's radiance. The exact value never exceeds one, but without a limit
/// samples close to a triangle or in a narrow lobe are fireflies. Energy is lost only nearer than about a fifth of the triangle's size, and
/// in lobes narrower than about 5 degrees.
const float kMaxMirrors = 4.0;

/// The row of the grid (render/lights/light_grid.h) for a point, and where its buffer's parts begin.
struct LightChoice {
  int row, row_texels, first_light;
};

LightChoice light_choice(vec3 position) {
  vec4 low = texelFetch(t_lights, 0), scale = texelFetch(t_lights, 1), cells = texelFetch(t_lights, 2);
  ivec3 c = ivec3(clamp(floor((position - low.xyz) * scale.xyz) + 1.0, vec3(0.0), cells.xyz - 1.0));
  LightChoice r;
  r.row_texels = int(low.w);
  r.row = 3 + int(scale.w) + ((c.z * int(cells.y) + c.y) * int(cells.x) + c.x) * (2 * r.row_texels + 1);
  r.first_light = int(cells.w);
  return r;
}

/// Number of light samples for `count` environment samples: from an eighth where the lights are dim to the same number where they are brighter.
/// In factors of two, by the irradiance that both would give the grid cell without occlusion.
int light_sample_count(LightChoice choice, int count) {
  float lights = texelFetch(t_lights, choice.row + 2 * choice.row_texels).x;  // lux, facing each
  float sky = 0.25 * u_frame.environment.z * u_frame.environment.w;           // mean over all surfaces
  int shift = 3 - int(lights > 0.25 * sky) - int(lights > 0.5 * sky) - int(lights > sky);
  return max(count >> shift, 1);
}

/// A light with the selection_pdf of the whole selection: the first node of the cut whose running sum exceeds u, and in it the light at
/// `position` of 2^32. Sums are whole steps of 2^-24. Loops are tested at their end (integrate.glsl).
LightRecord select_light(LightChoice choice, float u, uint position) {
  int low = 0, high = choice.row_texels - 1;
  do {
    int middle = (low + high) >> 1;
    if (texelFetch(t_lights, choice.row + middle).w > u) high = middle;
    else low = min(middle + 1, high);
  } while (low < high);
  vec4 sums = texelFetch(t_lights, choice.row + low), cut = texelFetch(t_lights, choice.row + choice.row_texels + low);
  float before = low > 0 ? texelFetch(t_lights, choice.row + max(low - 1, 0)).w : 0.0;
  int k = sums.x > u ? 0 : (sums.y > u ? 1 : (sums.z > u ? 2 : 3));
  float pdf = sums[k] - (k > 0 ? sums[max(k - 1, 0)] : before);
  vec4 node = texelFetch(t_lights, 3 + int(cut[k]));  // first light, their number, power before them, their own
  uint step, rest;
  umulExtended(position, uint(node.w * 16777216.0), step, rest);
  float sum = node.z + float(step) * (1.0 / 16777216.0);
  int first = choice.first_light + 4 * int(node.x);
  low = 0;
  high = int(node.y) - 1;
  do {
    int middle = (low + high) >> 1;
    if (texelFetch(t_lights, first + 4 * middle + 3).w > sum) high = middle;
    else low = min(middle + 1, high);
  } while (low < high);
  int at = first + 4 * low;
  vec4 a = texelFetch(t_lights, at), b = texelFetch(t_lights, at + 1), c = texelFetch(t_lights, at + 2), d = texelFetch(t_lights, at + 3);
  return LightRecord(a.xyz, floatBitsToUint(a.w), b.xyz, b.w, c.xyz, c.w * pdf / node.w, d.xyz, d.w);
}

struct LightDraw {
  LightRecord light;
  vec3 wi;          // local
  vec3 world;       // to the light
  float distance_m;
  vec3 outgoing;    // cd/m2, already divided by the probabilities; 0 where it does not shine
  float tinted;     // luminance of its part that the base colour scales, for a white one
};

/// Random numbers of sample `index` of a point.
struct LightNumbers {
  vec3 u;
  uint position;
};
LightNumbers light_numbers(uint rotation, uint index) {
  return LightNumbers(vec3(unit_float(hash(rotation ^ 0x3c6ef372u) + index * 0x9E3779B9u), unit_float(hash(rotation ^ 0xa54ff53au) + index * 0xC13FA9A9u),
                           unit_float(hash(rotation ^ 0x510e527fu) + index * 0x91E10DA5u)),
                      hash(rotation ^ 0x1f83d9abu) + index * 0xABC98388u);
}

LightDraw draw_light(Point p, LightChoice choice, LightNumbers n, vec2 xi) {
  LightDraw r;
  r.light = select_light(choice, n.u.x, n.position);
  LightSample s = light_sample(r.light, p.position, n.u.yz);
  r.world = s.wi;
  r.wi = to_local(p, environment_from_world(s.wi));
  r.distance_m = s.distance_m;
  r.outgoing = vec3(0.0);
  r.tinted = 0.0;
  if (r.wi.z <= 0.0) return r;
#if MEASURED
  r.outgoing = measured_brdf(p.slot, r.wi, p.wo, xi) * p.tint * s.radiance * r.wi.z;
#else
  AnalyticLobes lobes = evaluate_analytic(p.analytic, r.wi, p.wo);
  r.outgoing = lobes.total * s.radiance * r.wi.z;
  r.tinted = lobes.tinted * luminance(s.radiance) * r.wi.z;
#endif
  if (r.light.kind == kLightTriangle) {
    r.outgoing = min(r.outgoing, kMaxMirrors * r.light.color);
    r.tinted = min(r.tinted, kMaxMirrors * luminance(r.light.color));
  }
  float inverse_pdf = 1.0 / max(r.light.selection_pdf, 1e-20);
  r.outgoing *= inverse_pdf;
  r.tinted *= inverse_pdf;
  return r;
}

#if VISIBILITY == 2
VisibilityPoint g_light_visibility = VisibilityPoint(vec3(0.0), 0.0);  // set by main() of shade.comp
/// Visibility of a light by a ray, 0 or 1. The ray ends before the cells that contain the light, so that a lamp does not shadow itself.
float light_share(LightDraw d) {
  float t_max = d.distance_m - 2.0 * g_light_visibility.own_m;
  return t_max > 0.0 && blocked_at(g_light_visibility, d.world, t_max) >= 0.0 ? 0.0 : 1.0;
}
#endif

/// Mean over this work item's light samples, cd/m2; w: of LightDraw::tinted.
vec4 direct_lights(Point p, uint rotation, uint first_sample, int count) {
  LightChoice choice = light_choice(p.position);
  int samples = light_sample_count(choice, count);
  uint first = first_sample / uint(count) * uint(samples);
  vec4 sum = vec4(0.0);
  int i = 0;
  do {
    uint index = first + uint(i);
    LightDraw d = draw_light(p, choice, light_numbers(rotation, index), unit_pair(hash(rotation + index * 0xD1B54A33u)));
#if VISIBILITY == 2
    float share = light_share(d);
    d.outgoing *= share;
    d.tinted *= share;
#endif
    sum += vec4(d.outgoing, d.tinted);
  } while (++i < samples);
  return sum / float(samples);
}
