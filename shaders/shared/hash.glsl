// A number without order from a number. Source: Jarzynski and Olano 2020, "Hash functions for GPU rendering" (pcg).
#ifndef MAQUETTE_HASH
#define MAQUETTE_HASH
#ifndef MAQUETTE_FN
#define MAQUETTE_FN
#endif
MAQUETTE_FN uint hash(uint x) {
  x = x * 747796405u + 2891336453u;
  x = ((x >> ((x >> 28u) + 4u)) ^ x) * 277803737u;
  return (x >> 22u) ^ x;
}
/// Of a pixel of pictures of one seed.
MAQUETTE_FN uint hash_pixel(uint x, uint y, uint seed) { return hash(x + (y << 16u) + hash(seed)); }
#endif
