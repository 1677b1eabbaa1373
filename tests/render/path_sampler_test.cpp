#include "render/reference/path_sampler.h"

#include <gtest/gtest.h>

namespace maquette {
namespace {

TEST(PathSampler, PairsInLanesMatchSinglePairs) {
  std::uint32_t word = 1;
  const auto next = [&] { return word = mix_seed(word, 7); };
  for (int trial = 0; trial < 2000; ++trial) {
    const std::uint32_t seed = next();
    PathSampler::Pairs pairs;
    for (std::size_t i = 0; i < PathSampler::Pairs::kMost; ++i) {
      pairs.dimension[i] = trial % 2 == 0 ? next() : static_cast<std::uint32_t>(trial);
      pairs.index[i] = trial % 3 == 0 ? next() : static_cast<std::uint32_t>(i);
    }
    PathSampler::draw(seed, &pairs);
    for (std::size_t i = 0; i < PathSampler::Pairs::kMost; ++i) {
      const PathSampler one{seed, pairs.index[i]};
      ASSERT_EQ(pairs[i], one.pair(pairs.dimension[i])) << trial << " " << i;
    }
  }
}

}  // namespace
}  // namespace maquette
