// Random numbers of points.
#include "shared/hash.glsl"
float unit_float(uint x) { return float(x >> 8u) * (1.0 / 16777216.0); }
vec2 unit_pair(uint x) { return vec2(float(x >> 16u), float(x & 65535u)) * (1.0 / 65536.0); }
/// Uniform numbers of a pixel in a frame at rest: points of a sequence along the frames, shifted by a random vector of the pixel.
/// Source: Roberts 2018, "The unreasonable effectiveness of quasirandom sequences".
vec3 numbers_at_rest(ivec2 pixel, int frame) {
  uint seed = hash_pixel(uint(pixel.x), uint(pixel.y), uint(u_frame.sampling.w));
  vec3 shift = vec3(unit_float(seed), unit_float(hash(seed)), unit_float(hash(seed ^ 0x9E3779B9u)));
  return fract(shift + float(frame & 0xffff) * vec3(0.8191725134, 0.6710436067, 0.5497004779));
}
