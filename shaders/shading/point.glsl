// One shading point: its surface, frame and material, all in the environment's frame (rotation undone), so that rotating the environment
// needs no new tables. Needs frame, constants, latlong, octahedral, rgb9e5, gbuffer, material_table, analytic, merl included before.
#include "shared/bindings.glsl"
layout(binding = kUnitSurface) uniform usampler2D t_surface;
layout(binding = kUnitDepth) uniform sampler2D t_depth;
#if DETAILS
layout(binding = kUnitDetails) uniform usampler2DArray t_details;
#endif
layout(binding = kUnitBrdf) uniform usamplerBuffer t_brdf;              // [slot][theta_h][theta_d][phi_d], shared exponent
layout(binding = kUnitThetaCells) uniform samplerBuffer t_theta_cells;  // [slot][elevation][96], t begin and end
layout(binding = kUnitPhiCells) uniform samplerBuffer t_phi_cells;      // [slot][elevation][96][16], phi begin and end
layout(binding = kUnitAlbedo) uniform samplerBuffer t_albedo;           // [slot][64], luminance
#ifndef SEPARATE_SUN
#define SEPARATE_SUN 0  // 1: the sun's light is sampled separately (rotation/sun.comp)
#endif
#if SEPARATE_SUN
layout(binding = kUnitEnvironment) uniform usamplerBuffer t_sky;   // [height][width], shared exponent
#else
layout(binding = kUnitSkyNodes) uniform usamplerBuffer t_sky;   // [row][column] of nodes, shared exponent
#endif
layout(binding = kUnitLightSamples) uniform samplerBuffer t_light_samples;  // two texels: direction, pdf | radiance, -

const int kBrdfBias = 20;  // up to 1e6 1/sr: mirrors at grazing angles reach 5e5; full precision from 2.4e-4
const int kBrdfEntries = 1458000, kThetaCells = 96, kPhiCells = 16, kElevations = 32, kAlbedoEntries = 64;

struct Point {
  vec3 position;  // m, world
  vec3 n, t, b;   // environment frame
  vec3 wo;        // local frame
  float distance_m;
  int material;
  int slot;       // of the measured material's tables, or -1
  float inverse_albedo;
  float brdf_share;  // of the samples, in (0, 1)
  vec3 tint;
  float occlusion;   // of sky and baked light, not of the scene's lights
  AnalyticMaterial analytic;
  vec3 lobe_weights;
};

vec3 to_local(Point p, vec3 d) { return vec3(dot(p.t, d), dot(p.b, d), dot(p.n, d)); }
vec3 from_local(Point p, vec3 w) { return p.t * w.x + p.b * w.y + p.n * w.z; }

/// POINTS_SORTED: the includer's points are all measured (MEASURED 1) or all analytic, which saves a branch: software devices run both sides.
bool is_measured(uint flags) {
#ifdef POINTS_SORTED
  return MEASURED == 1;
#else
  return (flags & kMaterialMeasured) != 0u;
#endif
}

Point load_point(ivec2 pixel) {
  Point p;
  uvec4 g = texelFetch(t_surface, pixel, 0);
  float depth = texelFetch(t_depth, pixel, 0).x;
  Surface s = unpack_surface(g);
  p.occlusion = 1.0;
#if DETAILS
  s = unpack_details(s, texelFetch(t_details, ivec3(pixel, 0), 0), texelFetch(t_details, ivec3(pixel, 1), 0));
  p.occlusion = s.occlusion;
#endif
  vec3 ray = view_ray(pixel);
  p.position = view_origin(pixel) + ray * depth;
  p.distance_m = depth * length(ray);
  p.n = environment_from_world(s.normal);
  vec3 v = environment_from_world(-normalize(ray));
  // The view lies in the local xz plane: measured tables are isotropic and their importance cells are stored so.
  vec3 side = v - p.n * dot(p.n, v);
  float side2 = dot(side, side);
  if (side2 > 1e-10) {
    p.t = side * inversesqrt(side2);
    p.b = cross(p.n, p.t);
  } else {
    TangentBasis basis = tangent_basis(p.n);
    p.t = basis.t;
    p.b = basis.b;
  }
  p.wo = vec3(sqrt(side2), 0.0, max(dot(p.n, v), 1e-3));
  p.wo *= inversesqrt(dot(p.wo, p.wo));
  uvec4 words = material_words(s.material, 6);
  p.material = s.material;
  p.brdf_share = uintBitsToFloat(words.z);
  p.tint = vec3(1.0);
  p.slot = -1;
  if (is_measured(words.x)) {
    p.slot = int(words.y);
    if ((words.x & kMaterialTinted) != 0u) p.tint = s.base_color;
    float e = latlong_atan2(p.wo.x, p.wo.z) * (float(kAlbedoEntries - 1) * 0.63661977);
    int i = min(int(e), kAlbedoEntries - 2);
    float a = mix(texelFetch(t_albedo, p.slot * kAlbedoEntries + i).x, texelFetch(t_albedo, p.slot * kAlbedoEntries + i + 1).x,
                  e - float(i));
    p.inverse_albedo = 1.0 / max(a, 1e-6);
  } else {
    float ior = material_floats(s.material, 2).w;
    if (!has_textures(s.material) && material_floats(s.material, 3).w == 0.0) {
      // Not as the G-buffer rounds them.
      vec4 m1 = material_floats(s.material, 1);
      s.metallic = m1.x;
      s.roughness = m1.y;
    }
#if DETAILS
    p.analytic = make_analytic(s.base_color, s.metallic, s.roughness, ior, s.specular, s.specular_color, s.clearcoat, s.coat_roughness,
                               s.sheen_color, s.sheen_roughness);
#if ANALYTIC_ANISOTROPY
    if (s.anisotropy > 0.0) {
      vec3 along = environment_from_world(s.along);
      p.t = normalize(along - p.n * dot(along, p.n));
      p.b = cross(p.n, p.t);
      p.wo = normalize(vec3(dot(p.t, v), dot(p.b, v), max(dot(p.n, v), 1e-3)));
      p.analytic = with_anisotropy(p.analytic, s.anisotropy);
    }
#endif
#if ANALYTIC_COAT_NORMAL
    p.analytic.coat_normal = to_local(p, environment_from_world(s.coat_normal));
#endif
#if ANALYTIC_FILM
    p.analytic.film = s.film_nm > 0.0 ? s.film : 0.0;
    p.analytic.film_ior = material_floats(s.material, 7).y;
    p.analytic.film_nm = s.film_nm;
#endif
#else
    vec4 m3 = material_floats(s.material, 3), m4 = material_floats(s.material, 4);
    p.analytic = make_analytic(s.base_color, s.metallic, s.roughness, ior, m3.z, m4.rgb, m3.x, m3.y,
                               material_floats(s.material, 5).rgb, m4.w);
#endif
    p.lobe_weights = analytic_lobe_weights(p.analytic, p.wo);
    p.inverse_albedo = 1.0;
  }
  return p;
}

/// Where measured_brdf reads its table. Computed before the fetch, so that the fetches of several samples overlap.
struct BrdfLookup {
  int index;       // of the word at the lower bin centre along theta_h
  float fraction;  // of the upper one
};
BrdfLookup brdf_lookup(int slot, vec3 wi, vec3 wo, vec2 xi) {
  vec3 c = merl_coordinates(wi, wo);
  float theta_h = clamp(c.x, 0.0, 88.9999);
  int theta_d = clamp(int(floor(c.y + xi.x)), 0, 89);
  int phi_d = int(floor(c.z + xi.y));
  phi_d = phi_d < 0 ? phi_d + 180 : (phi_d >= 180 ? phi_d - 180 : phi_d);
  int i = int(theta_h);
  return BrdfLookup(slot * kBrdfEntries + merl_index(i, theta_d, phi_d), theta_h - float(i));
}
uvec2 fetch_brdf(BrdfLookup b) {
  return uvec2(texelFetch(t_brdf, b.index).x, texelFetch(t_brdf, b.index + kMerlPhiD * kMerlThetaD).x);
}
vec3 brdf_value(uvec2 words, float fraction) {
  return mix(unpack_rgb9e5(words.x, kBrdfBias), unpack_rgb9e5(words.y, kBrdfBias), fraction);
}
/// Measured BRDF: linear between bin centres along theta_h, where lobes are steep; along theta_d and phi_d one of the two
/// neighbours is chosen with its linear weight by `xi`, so that the expectation is the trilinear value at a quarter of the fetches.
/// Source: Pharr et al. 2024, "Filtering After Shading With Stochastic Texture Filtering", Sec. 4.
vec3 measured_brdf(int slot, vec3 wi, vec3 wo, vec2 xi) {
  BrdfLookup b = brdf_lookup(slot, wi, wo, xi);
  return brdf_value(fetch_brdf(b), b.fraction);
}

/// Index of one of the four nodes around, chosen with its bilinear weight by `xi`.
int environment_index(vec3 d, vec2 xi) {
#if SEPARATE_SUN
  ivec4 nodes = ivec4(u_frame.environment_size.xy, u_frame.environment_size.y - 1, 1);
#else
  ivec4 nodes = u_frame.sky_nodes;
#endif
  vec2 uv = latlong_uv_from_direction(d) * vec2(nodes.xy);
  ivec2 p = ivec2(floor(uv - 0.5 * float(nodes.w) + xi));
  p.x = p.x < 0 ? p.x + nodes.x : (p.x >= nodes.x ? p.x - nodes.x : p.x);
  p.y = clamp(p.y, 0, nodes.z);
  return p.y * nodes.x + p.x;
}
uint fetch_environment(int index) { return texelFetch(t_sky, index).x; }
/// Radiance of a fetched node, stored units.
vec3 environment_value(uint word) { return unpack_rgb9e5(word, u_frame.environment_size.z); }

int g_brdf_slot = 0;  // slot whose cells the shared sampler reads
vec2 fetch_theta_cell(int elevation, int k) {
  return texelFetch(t_theta_cells, (g_brdf_slot * kElevations + elevation) * kThetaCells + k).xy;
}
vec2 fetch_phi_cell(int elevation, int k, int p) {
  return texelFetch(t_phi_cells, ((g_brdf_slot * kElevations + elevation) * kThetaCells + k) * kPhiCells + p).xy;
}
#include "shared/brdf_sampling.glsl"
