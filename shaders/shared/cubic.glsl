// Roots of a cubic in single precision. Common subset of GLSL and C++ with GLM. Cardano's formula loses all digits where the leading
// coefficient or the discriminant is nearly 0. Here the roots are bracketed by the extrema and refined by Newton's method with the residual
// in twice the precision.
// Source: Blinn 2007, "How to Solve a Cubic Equation, Part 5"; Dekker 1971, "A Floating-Point Technique for Extending the Available
// Precision" (products and sums with their rounding errors).
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif
#ifdef GL_core_profile
#define PRECISE precise
#endif

// A value and its rounding error.
struct Twofold {
  float value, rest;
};

MAQUETTE_FN Twofold two_sum(float a, float b) {
  PRECISE float s = a + b;
  PRECISE float t = s - a;
  PRECISE float u = s - t;
  PRECISE float p = a - u;
  PRECISE float q = b - t;
  PRECISE float e = p + q;
  Twofold r;
  r.value = s;
  r.rest = e;
  return r;
}

// Upper 12 bits of the significand; by bits, so that no compiler can simplify it and nothing overflows.
MAQUETTE_FN float upper_half(float a) { return uintBitsToFloat(floatBitsToUint(a) & 0xfffff000u); }

MAQUETTE_FN Twofold two_product(float a, float b) {
  PRECISE float p = a * b;
  PRECISE float ah = upper_half(a);
  PRECISE float bh = upper_half(b);
  PRECISE float al = a - ah;
  PRECISE float bl = b - bh;
  PRECISE float e1 = ah * bh - p;
  PRECISE float e2 = e1 + ah * bl;
  PRECISE float e3 = e2 + al * bh;
  PRECISE float e4 = e3 + al * bl;
  Twofold r;
  r.value = p;
  r.rest = e4;
  return r;
}

// c[0] + c[1] k + c[2] k^2 + c[3] k^3. `rest`: rounding errors of `c`; without them the error of a root is its condition number times the
// rounding of the coefficients.
struct Cubic {
  vec4 c, rest;
};

// The value at k nearly as if in twice the precision.
// Source: Graillat, Langlois and Louvet 2009, "Algorithms for Accurate, Validated and Fast Polynomial Evaluation" (compensated Horner).
MAQUETTE_FN float cubic_value(Cubic f, float k) {
  float s = f.c[3], correction = f.rest[3];
  for (int i = 2; i >= 0; --i) {
    Twofold p = two_product(s, k);
    Twofold t = two_sum(p.value, f.c[i]);
    s = t.value;
    correction = correction * k + (p.rest + t.rest + f.rest[i]);
  }
  return s + correction;
}

MAQUETTE_FN float cubic_slope(vec4 c, float k) { return c[1] + k * (2.0f * c[2] + 3.0f * k * c[3]); }

// The root between lo and hi, where the cubic has one sign change: Newton's method, or bisection where a step would leave the interval.
MAQUETTE_FN float bracketed_root(Cubic f, float lo, float hi, bool rising) {
  float k = 0.5f * (lo + hi);
  for (int i = 0; i < 40; ++i) {
    float value = cubic_value(f, k), slope = cubic_slope(f.c, k);
    bool above = rising ? value > 0.0f : value < 0.0f;
    hi = above ? k : hi;
    lo = above ? lo : k;
    float next = abs(slope) > 0.0f ? k - value / slope : lo;
    if (abs(next - k) <= 6.0e-8f * abs(k)) return k;  // before the test of the interval, as k may be its end
    if (!(next > lo && next < hi)) next = 0.5f * (lo + hi);
    k = next;
  }
  return k;
}

struct CubicRoots {
  vec4 k;     // the first `count`, ascending; double roots count once, twice or not at all
  int count;
};

MAQUETTE_FN CubicRoots add_root(CubicRoots r, float k) {
  if (r.count > 3) return r;
  r.k[r.count] = k;
  r.count = r.count + 1;
  return r;
}

// Appends the roots in (0, 1], ascending, or, `reversed`, those in [1, infinity) of the polynomial whose coefficients these are in
// reverse order. The extrema cut the interval into pieces with at most one root each.
MAQUETTE_FN CubicRoots roots_in_unit(CubicRoots r, Cubic f, bool reversed) {
  vec4 c = f.c;
  float discriminant = c[2] * c[2] - 3.0f * c[1] * c[3];
  float q = -(c[2] + (c[2] < 0.0f ? -1.0f : 1.0f) * sqrt(max(discriminant, 0.0f)));
  float m1 = discriminant > 0.0f && abs(c[3]) > 0.0f ? clamp(q / (3.0f * c[3]), 0.0f, 1.0f) : 0.0f;
  float m2 = discriminant > 0.0f && abs(q) > 0.0f ? clamp(c[1] / q, 0.0f, 1.0f) : 0.0f;
  vec4 at = vec4(0.0f, min(m1, m2), max(m1, m2), 1.0f);
  vec4 value = vec4(c[0] + f.rest[0], cubic_value(f, at[1]), cubic_value(f, at[2]), cubic_value(f, 1.0f));
  for (int i = 0; i < 3; ++i) {
    int j = reversed ? 2 - i : i;
    float f0 = value[j], f1 = value[j + 1];
    if (at[j + 1] <= at[j] || !((f0 <= 0.0f && f1 > 0.0f) || (f0 >= 0.0f && f1 < 0.0f) || (f1 == 0.0f && f0 != 0.0f))) continue;
    float k = f1 == 0.0f ? at[j + 1] : bracketed_root(f, at[j], at[j + 1], f0 < f1);
    if (k > 0.0f) r = add_root(r, reversed ? 1.0f / k : k);
  }
  return r;
}

// Positive roots. Those above 1 are computed as reciprocals, so that a leading coefficient near zero becomes a harmless small constant
// term. Scaling by a power of two is exact.
MAQUETTE_FN CubicRoots positive_roots(Cubic f) {
  float largest = max(max(abs(f.c[0]), abs(f.c[1])), max(abs(f.c[2]), abs(f.c[3])));
  float scale = uintBitsToFloat(floatBitsToUint(largest) & 0x7f800000u);
  CubicRoots r;
  r.k = vec4(0.0f);
  r.count = 0;
  if (!(scale > 0.0f)) return r;
  f.c = f.c / scale;
  f.rest = f.rest / scale;
  r = roots_in_unit(r, f, false);
  f.c = vec4(f.c[3], f.c[2], f.c[1], f.c[0]);
  f.rest = vec4(f.rest[3], f.rest[2], f.rest[1], f.rest[0]);
  return roots_in_unit(r, f, true);
}
