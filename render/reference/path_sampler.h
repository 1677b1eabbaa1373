#pragma once

#include <array>
#include <cstdint>
#include <glm/glm.hpp>

#include "render/math/low_discrepancy.h"

namespace maquette {

/// Random numbers in [0, 1) of one path. Each dimension has its own scrambled and shuffled two-dimensional Sobol
/// sequence, so that the paths of one seed are well distributed in each pair of dimensions, for any number of paths.
/// Source: Burley 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4), Sec. 5 (padding by shuffled scrambling).
struct PathSampler {
  std::uint32_t seed = 0;   ///< identifies the pixel
  std::uint32_t index = 0;  ///< of the path

  glm::vec2 pair(std::uint32_t dimension) const {
    const std::uint32_t key = mix_seed(seed, dimension);
    const std::uint32_t i = owen_scramble(index, key);
    return {to_unit(reverse_bits(owen_scramble_reversed(i, key * 0x9e3779b9u + 1u))),
            to_unit(reverse_bits(owen_scramble_reversed(sobol_second_reversed(i), key * 0x85ebca6bu + 2u)))};
  }
  float single(std::uint32_t dimension) const {
    // Shuffled like the pairs, by a separate key: two scrambled copies of one sequence in the same order lie on a curve
    // in the plane, and a pixel whose choices do so never converges, for any number of paths.
    const std::uint32_t key = mix_seed(seed ^ 0x5bd1e995u, dimension);
    const std::uint32_t i = owen_scramble(index, key);
    return to_unit(reverse_bits(owen_scramble_reversed(i, key * 0xc2b2ae35u + 3u)));
  }
  /// A random word, not low-discrepancy.
  std::uint32_t word(std::uint32_t dimension) const { return mix_seed(mix_seed(seed, dimension), index); }

  /// Several pairs in SIMD lanes, of any dimensions and paths of one seed: the same values as `pair`, computed faster.
  struct Pairs {
    static constexpr std::size_t kMost = 8;
    alignas(32) std::array<std::uint32_t, kMost> dimension{}, index{};
    alignas(32) std::array<float, kMost> x, y;
    glm::vec2 operator[](std::size_t i) const { return {x[i], y[i]}; }
  };
  static void draw(std::uint32_t seed, Pairs* pairs);

 private:
  static float to_unit(std::uint32_t v) { return static_cast<float>(v >> 8) * 0x1p-24f; }
};

}  // namespace maquette
