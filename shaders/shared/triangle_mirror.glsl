// Reflection points on a triangle whose vertices have normals. Common subset of GLSL and C++ with GLM; needs cubic.glsl.
// The reflected directions d_i of the eye's rays at the three vertices are interpolated without normalising: p is seen at barycentrics
// (alpha, beta) when t1 + alpha e1 + beta e2 + k (d1 + alpha f1 + beta f2) = p, which is a cubic in k and then linear.
// Source: Mueller et al. 2007, "Towards predictive virtual prototyping", Sec. 11.2, Eq. 11.12 and 11.13.
// Differs: the cubic as (N0 + k N1 + k^2 N2) . (q - k d1); roots by cubic.glsl, the coefficients in twice the precision; which root.

// Quantities that depend only on triangle and eye. `_rest`: rounding error of the value before.
struct TriangleMirror {
  vec3 t1, e1, e2;      // m
  vec3 d1, f1, f2;      // unit direction at t1, differences of those at t2 and t3
  vec3 n0, n1, n2;      // (e1 + k f1) x (e2 + k f2) = n0 + k n1 + k^2 n2
  vec3 n0_rest, n1_rest, n2_rest;
  vec3 g, g_rest;       // n0 . d1, n1 . d1, n2 . d1
};

MAQUETTE_FN Twofold add_product(Twofold s, float a, float b) {
  Twofold p = two_product(a, b);
  Twofold t = two_sum(s.value, p.value);
  t.rest = t.rest + s.rest + p.rest;
  return t;
}

// (n + n_rest) . (q + q_rest) - (g + g_rest)
MAQUETTE_FN Twofold accurate_term(vec3 n, vec3 n_rest, vec3 q, vec3 q_rest, float g, float g_rest) {
  Twofold s;
  s.value = -g;
  s.rest = -g_rest;
  for (int i = 0; i < 3; ++i) {
    s = add_product(s, n[i], q[i]);
    s.rest = s.rest + n[i] * q_rest[i] + n_rest[i] * q[i];
  }
  return two_sum(s.value, s.rest);
}

// The cubic in k for the object p.
MAQUETTE_FN Cubic mirror_cubic(TriangleMirror m, vec3 p) {
  Twofold x = two_sum(p[0], -m.t1[0]), y = two_sum(p[1], -m.t1[1]), z = two_sum(p[2], -m.t1[2]);
  vec3 q = vec3(x.value, y.value, z.value), q_rest = vec3(x.rest, y.rest, z.rest);
  Twofold c0 = accurate_term(m.n0, m.n0_rest, q, q_rest, 0.0f, 0.0f), c1 = accurate_term(m.n1, m.n1_rest, q, q_rest, m.g[0], m.g_rest[0]);
  Twofold c2 = accurate_term(m.n2, m.n2_rest, q, q_rest, m.g[1], m.g_rest[1]);
  Cubic f;
  f.c = vec4(c0.value, c1.value, c2.value, -m.g[2]);
  f.rest = vec4(c0.rest, c1.rest, c2.rest, -m.g_rest[2]);
  return f;
}

struct MirrorPoint {
  float alpha, beta, k;
  float outside;  // 0 inside the triangle, else how far outside in barycentrics
  bool valid;     // on the part of the rays before they cross
};

MAQUETTE_FN MirrorPoint mirror_point_at(TriangleMirror m, vec3 p, float k) {
  // Barycentrics do not depend on this scale; without it the products would overflow for distant objects.
  float s = 1.0f / (1.0f + k);
  vec3 e1 = (m.e1 + k * m.f1) * s, e2 = (m.e2 + k * m.f2) * s, r = ((p - m.t1) - k * m.d1) * s;
  vec3 n = cross(e1, e2);
  float nn = max(dot(n, n), 1.0e-36f);
  MirrorPoint h;
  h.k = k;
  h.alpha = dot(cross(r, e2), n) / nn;
  h.beta = dot(cross(e1, r), n) / nn;
  h.outside = max(max(-h.alpha, -h.beta), max(h.alpha + h.beta - 1.0f, 0.0f));
  h.valid = dot(n, m.n0) > 0.0f;
  return h;
}

// The reflection point. Roots inside the triangle have priority, the nearest along the ray first; of those outside the one nearest to
// the triangle, on rays that have not crossed first, so that objects across the border stay connected. k < 0: there is none.
MAQUETTE_FN MirrorPoint mirror_point(TriangleMirror m, vec3 p) {
  CubicRoots roots = positive_roots(mirror_cubic(m, p));
  MirrorPoint best;
  best.alpha = best.beta = 0.0f;
  best.k = -1.0f;
  best.outside = 1.0e30f;
  best.valid = false;
  float best_cost = 1.0e31f;
  for (int i = 0; i < roots.count; ++i) {
    MirrorPoint h = mirror_point_at(m, p, roots.k[i]);
    float cost = h.outside > 0.0f ? h.outside + (h.valid ? 0.0f : 1.0e6f) : 0.0f;
    if (cost < best_cost) {
      best = h;
      best_cost = cost;
    }
  }
  return best;
}
