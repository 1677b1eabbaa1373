// Indirect light per vertex (render/indirect): radiance(w) = mean + gradient . w, 16 bytes.
// Common subset of GLSL and C++ with GLM (render/math/shared_formulas.h). Needs rgb9e5.glsl before it.
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

// Word x: mean, shared exponent. y, z, w: gradient of red, green and blue over the mean of that channel, three times ten bits. A
// non-negative radiance has a gradient of at most 4 means in this fit; it is clamped to 2 (all light from a fifth of the hemisphere).
const float kIndirectMaxGradient = 2.0f;

struct IndirectLight {
  vec3 mean;  // cd/m2
  vec3 red;   // gradients, world
  vec3 green;
  vec3 blue;
};

MAQUETTE_FN uint pack_indirect_gradient(vec3 gradient, float mean) {
  vec3 q = gradient / max(mean, 1.0e-30f);
  float size = sqrt(dot(q, q));
  q = q * (size > kIndirectMaxGradient ? kIndirectMaxGradient / size : 1.0f);
  vec3 u = clamp(q * (511.0f / kIndirectMaxGradient) + 511.5f, 0.0f, 1022.0f);
  return uint(u.x) | (uint(u.y) << 10u) | (uint(u.z) << 20u);
}

MAQUETTE_FN vec3 unpack_indirect_gradient(uint word, float mean) {
  vec3 u = vec3(float(word & 1023u), float((word >> 10u) & 1023u), float(word >> 20u));
  return (u - 511.0f) * (mean * kIndirectMaxGradient / 511.0f);
}

MAQUETTE_FN uvec4 pack_indirect(vec3 mean, vec3 red, vec3 green, vec3 blue, int bias) {
  return uvec4(pack_rgb9e5(mean, bias), pack_indirect_gradient(red, mean.x), pack_indirect_gradient(green, mean.y),
               pack_indirect_gradient(blue, mean.z));
}

MAQUETTE_FN IndirectLight unpack_indirect(uvec4 words, int bias) {
  IndirectLight light;
  light.mean = unpack_rgb9e5(words.x, bias);
  light.red = unpack_indirect_gradient(words.y, light.mean.x);
  light.green = unpack_indirect_gradient(words.z, light.mean.y);
  light.blue = unpack_indirect_gradient(words.w, light.mean.z);
  return light;
}

// Mean radiance over a lobe whose mean direction, weighted by f cos, is `w`; exact, because the radiance is linear. |w| < 1 for a wide lobe: 2/3 n
// for a Lambertian one.
MAQUETTE_FN vec3 indirect_radiance(IndirectLight light, vec3 w) {
  return max(light.mean + vec3(dot(light.red, w), dot(light.green, w), dot(light.blue, w)), vec3(0.0f));
}
