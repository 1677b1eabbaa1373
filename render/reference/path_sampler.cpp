#include "render/reference/path_sampler.h"

#include "render/math/wide.h"

namespace maquette {

MAQUETTE_WIDE void PathSampler::draw(std::uint32_t seed, Pairs* pairs) {
  const Pairs in = *pairs;  // local, so that the compiler knows that the loop does not write to what it reads
  Pairs out;
  for (std::size_t i = 0; i < Pairs::kMost; ++i) {
    const std::uint32_t key = mix_seed(seed, in.dimension[i]);
    const std::uint32_t shuffled = owen_scramble(in.index[i], key);
    const std::uint32_t first = reverse_bits(owen_scramble_reversed(shuffled, key * 0x9e3779b9u + 1u));
    const std::uint32_t second =
        reverse_bits(owen_scramble_reversed(sobol_second_reversed(shuffled), key * 0x85ebca6bu + 2u));
    // Signed integers convert to float faster.
    out.x[i] = static_cast<float>(static_cast<std::int32_t>(first >> 8)) * 0x1p-24f;
    out.y[i] = static_cast<float>(static_cast<std::int32_t>(second >> 8)) * 0x1p-24f;
  }
  pairs->x = out.x;
  pairs->y = out.y;
}

}  // namespace maquette
