#pragma once

#include <cstdint>

namespace maquette {

/// Sobol's sequence in two dimensions with nested uniform (Owen) scrambling.

inline std::uint32_t reverse_bits(std::uint32_t v) {
  v = ((v >> 1) & 0x55555555u) | ((v & 0x55555555u) << 1);
  v = ((v >> 2) & 0x33333333u) | ((v & 0x33333333u) << 2);
  v = ((v >> 4) & 0x0f0f0f0fu) | ((v & 0x0f0f0f0fu) << 4);
  v = ((v >> 8) & 0x00ff00ffu) | ((v & 0x00ff00ffu) << 8);
  return (v >> 16) | (v << 16);
}

/// Scrambles the digits of a bit-reversed number. Source: Burley 2020, "Practical Hash-based Owen Scrambling", JCGT
/// 9(4), Listing 1 (the permutation is Laine and Karras 2011).
inline std::uint32_t owen_scramble_reversed(std::uint32_t v, std::uint32_t seed) {
  v += seed;
  v ^= v * 0x6c50b47cu;
  v ^= v * 0xb82f1e52u;
  v ^= v * 0xc7afe638u;
  v ^= v * 0x8d22f6e6u;
  return v;
}
inline std::uint32_t owen_scramble(std::uint32_t v, std::uint32_t seed) {
  return reverse_bits(owen_scramble_reversed(reverse_bits(v), seed));
}

inline std::uint32_t mix_seed(std::uint32_t seed, std::uint32_t dimension) {
  std::uint32_t h = seed * 0x9e3779b9u + dimension * 0x85ebca6bu + 0xc2b2ae35u;
  h ^= h >> 16;
  h *= 0x7feb352du;
  h ^= h >> 15;
  h *= 0x846ca68bu;
  return h ^ (h >> 16);
}

/// Second Sobol dimension of `index`, bit-reversed; the first one is `index` itself, bit-reversed.
///
/// Its generator matrix is Pascal's triangle modulo 2 (Kollig and Keller 2002, "Efficient Multidimensional Sampling"),
/// which is the five-fold Kronecker power of ((1, 1), (0, 1)): one masked shift for each factor.
inline std::uint32_t sobol_second_reversed(std::uint32_t index) {
  index ^= index >> 16;
  index ^= (index & 0xff00ff00u) >> 8;
  index ^= (index & 0xf0f0f0f0u) >> 4;
  index ^= (index & 0xccccccccu) >> 2;
  index ^= (index & 0xaaaaaaaau) >> 1;
  return index;
}

}  // namespace maquette
