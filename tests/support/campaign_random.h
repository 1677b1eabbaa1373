#pragma once

#include <cmath>
#include <cstddef>
#include <glm/glm.hpp>
#include <random>

namespace maquette::test {

/// Most characters in the list of failures of a campaign.
inline constexpr std::size_t kEnough = 4000;

/// Random numbers and directions of a campaign's cases.
struct Random {
  std::mt19937_64 engine;
  double uniform(double a, double b) { return std::uniform_real_distribution<double>(a, b)(engine); }
  double log_uniform(double a, double b) { return std::exp(uniform(std::log(a), std::log(b))); }
  glm::dvec3 direction() {
    const double z = uniform(-1.0, 1.0), phi = uniform(0.0, 6.283185307179586), r = std::sqrt(1.0 - z * z);
    return {r * std::cos(phi), r * std::sin(phi), z};
  }
};

}  // namespace maquette::test
