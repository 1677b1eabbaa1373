// Parabolic map of the hemisphere about +z to the unit disc in [-1, 1]^2, and the local frames of surface light fields.
// Source: Heidrich and Seidel 1998, "View-independent Environment Maps", Sec. 3; one paraboloid.
// Common subset of GLSL and C++ with GLM (render/slf/parabolic.h).
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

// Unit direction above the horizon; the horizon is the unit circle.
MAQUETTE_FN vec2 parabolic_from_direction(vec3 w) {
  float scale = 1.0f / (1.0f + max(w.z, 0.0f));
  return vec2(w.x * scale, w.y * scale);
}

// Unit direction of a point of the disc.
MAQUETTE_FN vec3 direction_from_parabolic(vec2 p) {
  float r2 = p.x * p.x + p.y * p.y;
  float scale = 1.0f / (1.0f + r2);
  return vec3(2.0f * p.x * scale, 2.0f * p.y * scale, (1.0f - r2) * scale);
}

struct CarriedFrame {
  vec3 t;
  vec3 b;
};

// The frame of `axis`, carried to the normal `n` by the smallest rotation: it varies smoothly with n as long as n is not -axis. Both unit.
// Source: Hughes and Moller 1999, "Building an Orthonormal Basis from a Unit Vector" (rotation of one vector to another).
MAQUETTE_FN CarriedFrame carried_frame(vec3 axis, vec3 n) {
  float s = axis.z >= 0.0f ? 1.0f : -1.0f;
  float a = -1.0f / (s + axis.z);
  float c = axis.x * axis.y * a;
  vec3 t = vec3(1.0f + s * axis.x * axis.x * a, s * c, -s * axis.x);
  vec3 sum = axis + n;
  float scale = dot(t, n) / max(1.0f + dot(axis, n), 1.0e-6f);
  vec3 carried = t - sum * scale;
  CarriedFrame r;
  r.t = normalize(carried - n * dot(carried, n) + vec3(1.0e-20f, 0.0f, 0.0f));
  r.b = cross(n, r.t);
  return r;
}
