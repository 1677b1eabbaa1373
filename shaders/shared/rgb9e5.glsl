// Shared-exponent colour: three 9-bit mantissas and a 5-bit exponent in 32 bits, with a bias for each table, so that
// measured BRDFs (1e-6 .. 1e6 1/sr) and skies with a sun (1e9 : 1) both fit. Rounding error: 1/1022 to 1/512 of the
// largest channel at most. One word needs one gather, and gathers limit the speed of the shading kernels.
// Source: EXT_texture_shared_exponent. Differs: free bias.

#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif

/// `bias`: the exponent field e stands for a step of 2^(e - bias).
MAQUETTE_FN uint pack_rgb9e5(vec3 c, int bias) {
  float largest = max(max(c.x, c.y), c.z);
  if (!(largest > 0.0f)) return 0u;
  // Exponent of the largest channel from its bits: 2^x <= largest < 2^(x + 1), so a step of 2^(x - 8) keeps it below 512.
  int x = int((floatBitsToUint(largest) >> 23u) & 255u) - 127;
  int e = clamp(x - 8 + bias, 0, 31);
  float inverse_step = uintBitsToFloat(uint(127 + bias - e) << 23u);
  if (largest * inverse_step >= 511.5f && e < 31) {
    e += 1;
    inverse_step *= 0.5f;
  }
  uint r = uint(clamp(c.x * inverse_step + 0.5f, 0.0f, 511.0f));
  uint g = uint(clamp(c.y * inverse_step + 0.5f, 0.0f, 511.0f));
  uint b = uint(clamp(c.z * inverse_step + 0.5f, 0.0f, 511.0f));
  return r | (g << 9u) | (b << 18u) | (uint(e) << 27u);
}

MAQUETTE_FN vec3 unpack_rgb9e5(uint p, int bias) {
  float step_size = uintBitsToFloat(uint(int(p >> 27u) + 127 - bias) << 23u);
  return vec3(float(p & 511u), float((p >> 9u) & 511u), float((p >> 18u) & 511u)) * step_size;
}
