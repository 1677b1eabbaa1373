#include "tests/support/chi_square.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <numeric>
#include <unsupported/Eigen/SpecialFunctions>
#include <vector>

namespace maquette::test {

ChiSquare chi_square(std::span<const double> expected, std::span<const double> counted, double least,
                     double relative_error) {
  std::vector<std::size_t> order(expected.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return expected[a] < expected[b]; });
  ChiSquare result;
  int bins = 0;
  double pooled_expected = 0.0, pooled_counted = 0.0;
  const auto add = [&](double e, double c) {
    result.statistic += (c - e) * (c - e) / (e + e * e * relative_error * relative_error);
    ++bins;
  };
  for (const std::size_t i : order) {
    if (!(expected[i] > 0.0)) {
      result.outside += static_cast<int>(counted[i]);
      continue;
    }
    pooled_expected += expected[i];
    pooled_counted += counted[i];
    if (pooled_expected < least) continue;
    add(pooled_expected, pooled_counted);
    pooled_expected = pooled_counted = 0.0;
  }
  result.freedom = std::max(bins - 1, 0);
  if (result.freedom > 0) result.p = Eigen::numext::igammac(0.5 * result.freedom, 0.5 * result.statistic);
  return result;
}

std::uint32_t test_seed(std::uint32_t fixed) {
  const char* text = std::getenv("MAQUETTE_TEST_SEED");
  return text ? fixed + 2654435761u * static_cast<std::uint32_t>(std::strtoul(text, nullptr, 10)) : fixed;
}

std::size_t test_samples(std::size_t fixed) {
  const char* text = std::getenv("MAQUETTE_TEST_EFFORT");
  return text ? fixed * std::max(std::strtoul(text, nullptr, 10), 1ul) : fixed;
}

}  // namespace maquette::test
