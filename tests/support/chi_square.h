#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace maquette::test {

/// Pearson's test of counts against expectations.
struct ChiSquare {
  double statistic = 0.0;
  int freedom = 0;  ///< degrees of freedom: bins used, less one
  double p = 1.0;   ///< probability of a statistic as large as this when the expectations are right
  int outside = 0;  ///< counts in bins with an expectation of 0
};

/// `expected` and `counted` are over the same bins and should have the same sum: give samples outside all bins a bin of
/// their own. Bins that expect fewer than `least` are pooled in the order of their expectation, as Cochran 1952 asks.
/// `relative_error`: accuracy of the expectations themselves. Source: Pharr et al. 2023, "Physically Based Rendering",
/// 4th ed., tests of the samplers.
ChiSquare chi_square(std::span<const double> expected, std::span<const double> counted, double least = 5.0,
                     double relative_error = 0.0);

/// Seed of a randomised test: `fixed`; MAQUETTE_TEST_SEED (for campaigns) is mixed in, if set.
std::uint32_t test_seed(std::uint32_t fixed);
/// Samples of a randomised test: `fixed` times MAQUETTE_TEST_EFFORT, if that is set.
std::size_t test_samples(std::size_t fixed);

}  // namespace maquette::test
