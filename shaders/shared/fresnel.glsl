// Exact Fresnel reflectance of dielectrics and of a pane. Common subset of GLSL and C++ with GLM (render/math/shared_formulas.h in float,
// render/inspection/pane_formulas.h in double).
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif
#if defined(GL_core_profile) && !defined(Real)
#define Real float
#endif

// Reflectance of one surface for s and p polarisation; cos_i in [0, 1] on the side of air, n: refractive index, at least 1.
// Source: Born and Wolf 1999, "Principles of Optics", Sec. 1.5.2, Eq. 21.
MAQUETTE_FN vec2 fresnel_sp(Real cos_i, Real n) {
  Real c = clamp(cos_i, Real(0.0f), Real(1.0f));
  Real cos_t = sqrt(max(Real(1.0f) - (Real(1.0f) - c * c) / (n * n), Real(0.0f)));
  Real s = (c - n * cos_t) / max(c + n * cos_t, Real(1.0e-20f));
  Real p = (n * c - cos_t) / max(n * c + cos_t, Real(1.0e-20f));
  return vec2(s * s, p * p);
}

MAQUETTE_FN Real fresnel_surface(Real cos_i, Real n) {
  vec2 r = fresnel_sp(cos_i, n);
  return Real(0.5f) * (r.x + r.y);
}

// Reflectance and transmittance of a pane for s (x) and p polarisation (y).
struct PolarisedPane {
  vec2 reflected;
  vec2 transmitted;
};

// All bounces between the faces of a pane, without interference. `inside`: internal transmittance of one crossing, in [0, 1]; at 1 both
// sum to 1.
// Source: Stokes 1862, "On the Intensity of the Light Reflected from or Transmitted through a Pile of Plates".
//
// Differs: both amplitudes are (a - b) / (a + b) with b = n cos_t, so that a face reflects m / s = (a - b)^2 / (a + b)^2 and
// transmits (s - m) / s with s - m = 4 a b, which keeps its precision at grazing incidence. With t for `inside` the sums of all bounces are
// T = 4 a b / (s + m t) * 4 a b t / (s - m t) and R = m / s (1 + t T).
MAQUETTE_FN PolarisedPane fresnel_pane_sp(Real cos_i, Real n, Real inside) {
  Real c = clamp(cos_i, Real(1.0e-7f), Real(1.0f));
  Real b = sqrt(max((n - Real(1.0f)) * (n + Real(1.0f)), Real(0.0f)) + c * c);
  vec2 a = vec2(c, n * n * c);
  vec2 s = vec2((a.x + b) * (a.x + b), (a.y + b) * (a.y + b));
  vec2 m = vec2((a.x - b) * (a.x - b), (a.y - b) * (a.y - b));
  vec2 passes = a * (Real(4.0f) * b);
  vec2 stays = passes + m * (Real(1.0f) - inside);
  PolarisedPane pane;
  pane.transmitted = passes * passes * inside / (stays * (s + m * inside));
  pane.reflected = m / s * (vec2(1.0f, 1.0f) + pane.transmitted * inside);
  return pane;
}

// The same, averaged over both polarisations: reflectance (x) and transmittance (y).
MAQUETTE_FN vec2 fresnel_pane(Real cos_i, Real n, Real inside) {
  PolarisedPane pane = fresnel_pane_sp(cos_i, n, inside);
  return vec2(Real(0.5f) * (pane.reflected.x + pane.reflected.y), Real(0.5f) * (pane.transmitted.x + pane.transmitted.y));
}

// The reflectance of a pane in two parts: of its front face alone (x), and of all light that returns from the inside (y). Their sum is that of
// fresnel_pane.
MAQUETTE_FN vec2 fresnel_faces(Real cos_i, Real n, Real inside) {
  Real front = fresnel_surface(cos_i, n);
  return vec2(front, max(fresnel_pane(cos_i, n, inside).x - front, Real(0.0f)));
}
