// Latitude-longitude maps of render/prefilter/prefiltered_maps.h and the reflectance table of reflectance_tables.h.
#include "shared/bindings.glsl"
layout(binding = kUnitPrefilteredMaps) uniform samplerBuffer t_maps;    // texel i: offset, width, height of map i, map count; then the maps
layout(binding = kUnitReflectance) uniform sampler2D t_reflectance;  // x: n.v, y: roughness; split-sum scale and bias, sheen, diffuse Schlick weight

int map_count() { return int(texelFetch(t_maps, 0).w); }

/// Bilinear, longitude wraps, poles clamp. `uv` from latlong_uv_from_direction.
vec3 map_bilinear(int map, vec2 uv) {
  vec3 header = texelFetch(t_maps, map).xyz;
  ivec2 size = ivec2(header.yz);
  vec2 at = uv * header.yz - 0.5;
  ivec2 p = ivec2(floor(at));
  vec2 f = at - vec2(p);
  int x0 = p.x < 0 ? p.x + size.x : p.x;
  int x1 = p.x + 1 >= size.x ? p.x + 1 - size.x : p.x + 1;
  int row0 = int(header.x) + clamp(p.y, 0, size.y - 1) * size.x;
  int row1 = int(header.x) + clamp(p.y + 1, 0, size.y - 1) * size.x;
  return mix(mix(texelFetch(t_maps, row0 + x0).rgb, texelFetch(t_maps, row0 + x1).rgb, f.x),
             mix(texelFetch(t_maps, row1 + x0).rgb, texelFetch(t_maps, row1 + x1).rgb, f.x), f.y);
}

/// Between two of `count` maps that begin at `first`.
vec3 map_trilinear(int first, int count, float level, vec2 uv) {
  float l = clamp(level, 0.0, float(count - 1));
  int i = min(int(l), count - 2);
  return mix(map_bilinear(first + i, uv), map_bilinear(first + i + 1, uv), l - float(i));
}

/// Irradiance over pi.
vec3 diffuse_light(vec3 n) { return map_bilinear(0, latlong_uv_from_direction(n)); }

vec4 reflectance(float nv, float roughness) { return textureLod(t_reflectance, vec2(nv, roughness), 0.0); }

/// Reflectances of an analytic material's lobes under a sky of radiance 1: of the base's GGX lobe, of the coat's, and of the lobes
/// that use the irradiance (diffuse and sheen).
struct AnalyticReflectance {
  vec3 diffuse;
  vec3 specular;
  float coat;
};

/// Where a coat is seen from, around its own normal.
vec3 coat_view(AnalyticMaterial m, vec3 wo) {
  vec3 w = around_coat(m, wo);
  return vec3(w.xy, max(w.z, 1e-3));
}

/// The factors (1 - F) of the diffuse lobe and of the coat are averaged over incident light. `wo`: local.
AnalyticReflectance analytic_reflectance(AnalyticMaterial m, vec3 wo, float sheen_roughness) {
  float nv = wo.z;
  AnalyticReflectance r;
  vec4 base = reflectance(nv, sqrt(mean_alpha(m)));
  vec3 f0 = base_f0(m, nv);
  float largest_f0 = max(max(f0.x, f0.y), f0.z);
  r.specular = f0 * base.x + vec3(m.f90 * base.y);
  r.diffuse = m.diffuse * (1.0 - mix(largest_f0, max(m.f90, largest_f0), base.w));
  r.coat = 0.0;
#if ANALYTIC_SHEEN
  if (has_sheen(m)) {
    float below = below_sheen(m, nv);
    r.specular *= below;
    // The light comes from all sides: at 60 degrees from the normal in the mean.
    r.diffuse = r.diffuse * min(below, below_sheen(m, 0.5)) + m.sheen * reflectance(nv, sheen_roughness).z;
  }
#endif
  if (m.coat > 0.0) {
    float nc = coat_view(m, wo).z;
    vec4 coat = reflectance(nc, sqrt(m.coat_alpha));
    r.coat = m.coat * (0.04 * coat.x + coat.y);
    r.diffuse *= 1.0 - m.coat * mix(0.04, 1.0, coat.w);
    r.specular *= 1.0 - m.coat * mix(0.04, 1.0, schlick_weight(nc));
  }
  return r;
}
