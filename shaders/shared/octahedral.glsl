// Octahedral map of the full sphere to [0, 1]^2; +Y is the centre, -Y the four corners, u follows x and v follows z.
// Source: Cigolle et al. 2014, "A Survey of Efficient Representations for Independent Unit Vectors", Sec. 3.3 ("oct").
// Differs: the pole is +Y, the product's up axis, and the square is [0, 1]^2.
// Common subset of GLSL and C++ with GLM (render/math/shared_formulas.h).
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

// (1 - |other|) with the sign of p: folds the lower half sphere outwards; 0 is treated as positive so that the map has no hole.
MAQUETTE_FN float octahedral_fold(float p, float other) { return p >= 0.0f ? 1.0f - abs(other) : abs(other) - 1.0f; }

// Direction of any length above 0.
MAQUETTE_FN vec2 octahedral_from_direction(vec3 d) {
  float scale = 1.0f / max(abs(d.x) + abs(d.y) + abs(d.z), 1.0e-30f);
  float p = d.x * scale;
  float q = d.z * scale;
  bool below = d.y < 0.0f;
  float u = below ? octahedral_fold(p, q) : p;
  float v = below ? octahedral_fold(q, p) : q;
  return vec2(u * 0.5f + 0.5f, v * 0.5f + 0.5f);
}

// Unit direction of a point of the square.
MAQUETTE_FN vec3 direction_from_octahedral(vec2 uv) {
  float u = uv.x * 2.0f - 1.0f;
  float v = uv.y * 2.0f - 1.0f;
  float y = 1.0f - abs(u) - abs(v);
  float x = y < 0.0f ? octahedral_fold(u, v) : u;
  float z = y < 0.0f ? octahedral_fold(v, u) : v;
  return normalize(vec3(x, y, z));
}
