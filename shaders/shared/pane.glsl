// The second image of a pane: the reflection by its back face. Common subset of GLSL and C++ with GLM (render/math/shared_formulas.h
// in float, render/inspection/pane_formulas.h in double).
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif
#if defined(GL_core_profile) && !defined(Real)
#define Real float
#endif

// A ray that entered a pane and left it again on the same side.
struct GhostRay {
  vec3 offset;     // m, from where it entered
  vec3 direction;  // unit
  bool valid;      // false: it does not leave the pane (total reflection in a strong wedge)
};

// Snell's law for a unit direction at a unit normal that faces it; eta: index before over index behind. 0: total reflection.
MAQUETTE_FN vec3 pane_refract(vec3 direction, vec3 normal, Real eta) {
  Real c = -dot(direction, normal);
  Real k = Real(1.0f) - eta * eta * (Real(1.0f) - c * c);
  return k < Real(0.0f) ? vec3(0.0f, 0.0f, 0.0f) : eta * direction + (eta * c - sqrt(k)) * normal;
}

// The ray that is refracted into the pane, reflected by its back, and refracted out again. `front`, `back`, `leaving`: the normals at these three
// points, all towards the viewer. For parallel flat faces it is parallel to the ray reflected by the front, at a distance of
// 2 t tan(theta') cos(theta).
MAQUETTE_FN GhostRay pane_ghost(vec3 direction, vec3 front, vec3 back, vec3 leaving, Real n, Real thickness) {
  vec3 inside = pane_refract(direction, front, Real(1.0f) / n);
  vec3 mirrored = inside - back * (Real(2.0f) * dot(back, inside));
  GhostRay r;
  vec3 outside = pane_refract(mirrored, -leaving, n);
  r.valid = dot(outside, outside) > Real(0.5f) && dot(mirrored, front) > Real(1.0e-3f);
  Real up = max(dot(mirrored, front), Real(1.0e-3f));
  r.offset = inside * (thickness / max(-dot(inside, front), Real(1.0e-6f))) + mirrored * (thickness / up);
  r.direction = r.valid ? outside * inversesqrt(dot(outside, outside)) : direction;
  return r;
}
