#pragma once

#include <cstdint>
#include <string>

namespace maquette {

/// Results of a run of random and adversarial triangle projections, against long double.
struct TriangleCampaign {
  std::size_t cases = 0;
  std::size_t simple_roots = 0;  ///< of the reference, with k > 0 and a condition number up to 1e3
  std::size_t missed = 0;        ///< of them without a float root within 1e-4 relative
  std::size_t other_roots = 0;   ///< float roots with a larger condition number
  std::size_t stray = 0;         ///< of them with a residual above 1e-4 of the triangle's size there
  std::size_t wrong_choice = 0;  ///< the reference has a root well inside the triangle, but no such root was chosen
  std::size_t not_finite = 0;
  double worst_simple = 0.0;  ///< largest relative error of a simple root
  double worst_stray = 0.0;   ///< largest residual of another root, in triangle sizes
  std::string failures;       ///< the first few, a line each
};

TriangleCampaign run_triangle_campaign(std::size_t cases, std::uint64_t seed);

}  // namespace maquette
