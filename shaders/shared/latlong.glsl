// Directions and latitude-longitude maps, OpenEXR LATLONG: v = 0 is +Y, the centre (0.5, 0.5) is +Z, longitude atan2(x, z) is
// +pi at u = 0 and -pi at u = 1. Texel centres are at ((x + 0.5) / W, (y + 0.5) / H).
// Common subset of GLSL and C++ with GLM (render/math/shared_formulas.h).
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

// atan(q) for q in [0, 1], odd polynomial of degree 11, error below 2e-6 rad.
// Source: our own weighted least-squares fit (Lawson's iteration) of the maximum error over 4,000 Chebyshev points.
MAQUETTE_FN float latlong_atan_unit(float q) {
  float s = q * q;
  float p = -0.0117191300f;
  p = p * s + 0.0526473373f;
  p = p * s - 0.1164264679f;
  p = p * s + 0.1935403645f;
  p = p * s - 0.3326228261f;
  p = p * s + 0.9999772310f;
  return p * q;
}

// atan2(y, x) in [-pi, pi], error below 4e-6 rad; 0 for (0, 0).
MAQUETTE_FN float latlong_atan2(float y, float x) {
  float ax = abs(x);
  float ay = abs(y);
  float small_side = min(ax, ay);
  float large_side = max(max(ax, ay), 1.0e-30f);
  float a = latlong_atan_unit(small_side / large_side);
  a = ay > ax ? 1.57079632679f - a : a;
  a = x < 0.0f ? 3.14159265359f - a : a;
  return y < 0.0f ? -a : a;
}

// uv in [0, 1]^2 of a direction (any length above 0). Angular error below 1e-5 rad; the latitude comes from atan2, because
// asin(y) loses half of the digits near the poles.
MAQUETTE_FN vec2 latlong_uv_from_direction(vec3 d) {
  float longitude = latlong_atan2(d.x, d.z);
  float latitude = latlong_atan2(d.y, sqrt(d.x * d.x + d.z * d.z));
  return vec2(0.5f - longitude * 0.15915494309f, 0.5f - latitude * 0.31830988618f);
}

// Unit direction of a point of the map.
MAQUETTE_FN vec3 direction_from_latlong_uv(vec2 uv) {
  float longitude = 3.14159265359f - uv.x * 6.28318530718f;
  float latitude = 1.57079632679f - uv.y * 3.14159265359f;
  float c = cos(latitude);
  return vec3(sin(longitude) * c, sin(latitude), cos(longitude) * c);
}

// d rotated about +Y by the angle whose cosine and sine are given, positive from +Z towards +X. The radiance from direction d of an environment
// rotated by +angle is that of the unrotated map at latlong_rotate(d, cos(angle), -sin(angle)).
MAQUETTE_FN vec3 latlong_rotate(vec3 d, float cosine, float sine) {
  return vec3(cosine * d.x + sine * d.z, d.y, cosine * d.z - sine * d.x);
}
