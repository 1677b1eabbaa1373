// Exact Fresnel reflectance of dielectrics and of a pane. Common subset of GLSL and C++ with GLM (render/math/shared_formulas.h).
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

// Reflectance of one surface for s and p polarisation; cos_i in [0, 1] on the side of air, n: refractive index, at least 1.
// Source: Born and Wolf 1999, "Principles of Optics", Sec. 1.5.2, Eq. 21.
MAQUETTE_FN vec2 fresnel_sp(float cos_i, float n) {
  float c = clamp(cos_i, 0.0f, 1.0f);
  float cos_t = sqrt(max(1.0f - (1.0f - c * c) / (n * n), 0.0f));
  float s = (c - n * cos_t) / max(c + n * cos_t, 1.0e-20f);
  float p = (n * c - cos_t) / max(n * c + cos_t, 1.0e-20f);
  return vec2(s * s, p * p);
}

MAQUETTE_FN float fresnel_surface(float cos_i, float n) {
  vec2 r = fresnel_sp(cos_i, n);
  return 0.5f * (r.x + r.y);
}

// Reflectance (x) and transmittance (y) of a pane: all bounces between its faces, without interference, per polarisation and then
// averaged. `inside`: internal transmittance of one crossing, in [0, 1]; at 1 both sum to 1.
// Source: Stokes 1862, "On the Intensity of the Light Reflected from or Transmitted through a Pile of Plates".
//
// Differs: both amplitudes are (a - b) / (a + b) with b = n cos_t, so that a face reflects m / s = (a - b)^2 / (a + b)^2 and
// transmits (s - m) / s with s - m = 4 a b, which keeps its precision at grazing incidence. With t for `inside` the sums of all bounces are
// T = 4 a b / (s + m t) * 4 a b t / (s - m t) and R = m / s (1 + t T).
MAQUETTE_FN vec2 fresnel_pane(float cos_i, float n, float inside) {
  float c = clamp(cos_i, 1.0e-7f, 1.0f);
  float b = sqrt(max((n - 1.0f) * (n + 1.0f), 0.0f) + c * c);
  vec2 a = vec2(c, n * n * c);
  vec2 s = vec2((a.x + b) * (a.x + b), (a.y + b) * (a.y + b));
  vec2 m = vec2((a.x - b) * (a.x - b), (a.y - b) * (a.y - b));
  vec2 passes = a * (4.0f * b);
  vec2 stays = passes + m * (1.0f - inside);
  vec2 transmitted = passes * passes * inside / (stays * (s + m * inside));
  vec2 reflected = m / s * (vec2(1.0f, 1.0f) + transmitted * inside);
  return vec2(0.5f * (reflected.x + reflected.y), 0.5f * (transmitted.x + transmitted.y));
}

// The reflectance of a pane in two parts: of its front face alone (x), and of all light that returns from the inside (y). Their sum is that of
// fresnel_pane.
MAQUETTE_FN vec2 fresnel_faces(float cos_i, float n, float inside) {
  float front = fresnel_surface(cos_i, n);
  return vec2(front, max(fresnel_pane(cos_i, n, inside).x - front, 0.0f));
}
