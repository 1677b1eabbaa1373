// Punctual lights (KHR_lights_punctual) and emissive triangles as sampled lights, and the local bandwidth of a near light.
// Common subset of GLSL and C++ with GLM (render/math/shared_formulas.h).
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

const uint kLightDirectional = 0u;
const uint kLightPoint = 1u;
const uint kLightSpot = 2u;
const uint kLightTriangle = 3u;

// One sampled light of the GPU list: 64 bytes, std430.
struct LightRecord {
  vec3 position;        // m; first vertex of an emissive triangle; unused for directional
  uint kind;            // kLight...
  vec3 direction;       // unit, where the light shines; triangle: edge 1 (m); it shines to the side of cross(edge 1, edge 2)
  float range_m;        // 0: infinite; triangle: 1 where it shines to both sides
  vec3 color;           // lux, candela, or emitted radiance (cd/m2)
  float selection_pdf;  // probability of choosing this light: by power
  vec3 edge2;           // triangle: edge 2 (m); spot: (cos inner, cos outer, 0)
  float cdf;            // cumulative selection probability, inclusive
};

// Contribution of one light sample at a point. Outgoing radiance: sum of f(wi, wo) cos(theta_i) radiance / selection_pdf.
struct LightSample {
  vec3 wi;           // unit, towards the light; 0 where radiance is 0
  float distance_m;  // 1e30 for directional
  vec3 radiance;     // emitted * geometry / density of the sample: lux for lights without extent
  float pdf;         // 1/sr of wi for the chosen light; 0 for lights without extent
};

MAQUETTE_FN LightSample light_nothing() {
  LightSample s;
  s.wi = vec3(0.0f, 0.0f, 0.0f);
  s.distance_m = 0.0f;
  s.radiance = vec3(0.0f, 0.0f, 0.0f);
  s.pdf = 0.0f;
  return s;
}

// Smooth end of a light's range, without the inverse square. Source: KHR_lights_punctual, "Range Property".
MAQUETTE_FN float light_range_window(float distance_m, float range_m) {
  float q = range_m > 0.0f ? distance_m / range_m : 0.0f;
  float q2 = q * q;
  return clamp(1.0f - q2 * q2, 0.0f, 1.0f);
}

// Source: KHR_lights_punctual, "Inner and Outer Cone Angles".
MAQUETTE_FN float light_cone_window(float cos_angle, float cos_inner, float cos_outer) {
  float t = clamp((cos_angle - cos_outer) / max(cos_inner - cos_outer, 0.001f), 0.0f, 1.0f);
  return t * t;
}

// Uniform on the triangle, by area. Source: Pharr et al. 2023, "Physically Based Rendering", 4th ed., Sec. A.5.1 (square root).
MAQUETTE_FN vec2 light_triangle_uv(vec2 u) {
  float root = sqrt(u.x);
  return vec2(root * (1.0f - u.y), root * u.y);
}

// Vectors are scaled by their largest component before lengths are squared: the square of 1e-20 m underflows in float.
MAQUETTE_FN float light_largest(vec3 v) { return max(abs(v.x), max(abs(v.y), abs(v.z))); }

MAQUETTE_FN LightSample light_sample_triangle(LightRecord light, vec3 point, vec2 u) {
  vec2 uv = light_triangle_uv(u);
  vec3 to = light.position + light.direction * uv.x + light.edge2 * uv.y - point;
  float to_scale = light_largest(to);
  float edge_scale = max(light_largest(light.direction), light_largest(light.edge2));
  if (!(to_scale > 0.0f) || !(edge_scale > 0.0f)) {
    return light_nothing();
  }
  float distance_m = length(to / to_scale) * to_scale;
  vec3 wi = to / distance_m;
  vec3 doubled = cross(light.direction / edge_scale, light.edge2 / edge_scale);  // normal times twice the area / scale^2
  float facing = -dot(doubled, wi);
  facing = light.range_m > 0.0f ? abs(facing) : facing;
  if (!(facing > 0.0f)) {
    return light_nothing();
  }
  float size_over_distance = edge_scale / distance_m;
  float solid_angle = 0.5f * facing * size_over_distance * size_over_distance;  // cos A / d^2 = 1 / pdf
  LightSample s;
  s.wi = wi;
  s.distance_m = distance_m;
  s.radiance = light.color * solid_angle;
  s.pdf = 1.0f / max(solid_angle, 1.0e-30f);
  return s;
}

MAQUETTE_FN LightSample light_sample_punctual(LightRecord light, vec3 point) {
  vec3 to = light.position - point;
  float scale = light_largest(to);
  if (!(scale > 1.0e-15f)) {
    return light_nothing();
  }
  LightSample s;
  s.distance_m = length(to / scale) * scale;
  s.wi = to / s.distance_m;
  s.pdf = 0.0f;
  float window = light_range_window(s.distance_m, light.range_m);
  if (light.kind == kLightSpot) {
    window = window * light_cone_window(-dot(light.direction, s.wi), light.edge2.x, light.edge2.y);
  }
  s.radiance = light.color * (window / (s.distance_m * s.distance_m));
  return s;
}

// u in [0, 1)^2, used by triangles only. Visibility and the receiver's cosine are the caller's.
MAQUETTE_FN LightSample light_sample(LightRecord light, vec3 point, vec2 u) {
  if (light.kind == kLightTriangle) {
    return light_sample_triangle(light, point, u);
  }
  if (light.kind == kLightDirectional) {
    LightSample s;
    s.wi = -light.direction;
    s.distance_m = 1.0e30f;
    s.radiance = light.color;
    s.pdf = 0.0f;
    return s;
  }
  return light_sample_punctual(light, point);
}

// Local spatial bandwidth (cycles/m, across the ray; times cos(theta_i) on the surface) of the light that a point receives from a near light
// along wi at distance_m, for a BRDF of local angular bandwidth nu_rho (cycles/rad).
//
// The spectrum of a light of extent s that emits equally in all directions is purely spatial at the light, (1 / s, 0). Travel by d shears it to a
// line: nu_theta = d nu_x. The BRDF limits |nu_theta| to nu_rho, so that nu_x <= nu_rho / d. A point light (s = 0) has nu_rho / d; a large light has
// at most the bandwidth of its extent, 2.06 / s.
// The inverse square and the two cosines vary even for a Lambertian surface: for a point light at height d over a plane the
// irradiance is d (d^2 + x^2)^-1.5, its spectrum exp(-2 pi nu d), and 95 % of the energy lies below 0.3775 / d, which is
// the minimum. The intensity of a spot changes by half a cycle over the width w of its penumbra: (0, 1 / (2 w)) at the light is
// 1 / (2 w d) at the receiver.
// Source: Durand et al. 2005, "A Frequency Analysis of Light Transport", Sec. 3 (shear); the numbers are ours.
MAQUETTE_FN float light_bandwidth(LightRecord light, vec3 wi, float distance_m, float nu_rho) {
  if (light.kind == kLightDirectional) {
    return 0.0f;
  }
  float nu_theta = max(nu_rho, 0.3775f);
  float d = max(distance_m, 1.0e-15f);
  float nu_x = nu_theta / d;
  if (light.kind == kLightTriangle) {
    // A slit of width s holds 95 % of its energy below 2.06 / s.
    float edge_scale = max(light_largest(light.direction), light_largest(light.edge2));
    vec3 doubled = cross(light.direction / max(edge_scale, 1.0e-30f), light.edge2 / max(edge_scale, 1.0e-30f));
    float extent = edge_scale * sqrt(length(doubled));
    nu_x = min(nu_x, 2.06f / max(extent, 1.0e-15f));
  }
  if (light.kind == kLightSpot) {
    float cos_inner = light.edge2.x;
    float cos_outer = light.edge2.y;
    float step_cos = max(cos_inner - cos_outer, 0.001f);
    float sine = sqrt(max(1.0f - cos_outer * cos_outer, 1.0e-6f));
    float width_rad = step_cos / sine;
    float inside = (-dot(light.direction, wi) - cos_inner) / step_cos;  // 0 on the inner cone, 1 a penumbra further in
    nu_x = nu_x + clamp(1.0f - inside, 0.0f, 1.0f) * 0.5f / (width_rad * d);
  }
  return nu_x;
}
