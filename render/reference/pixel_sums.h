#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <glm/glm.hpp>

namespace maquette {

/// Sums over the paths of one pixel, in double: a float sum stops growing at 1.7e7 equal terms, and loses the variance
/// long before.
struct PixelSums {
  glm::dvec3 sum{0.0};
  glm::dvec3 square{0.0};
  std::uint32_t count = 0;
  std::uint32_t covered = 0;
  std::uint64_t rays = 0;
};

inline glm::dvec3 variance_of_mean(const PixelSums& p) {
  if (p.count < 2) return glm::dvec3(0.0);
  const double n = p.count;
  const glm::dvec3 variance = glm::max(p.square - p.sum * p.sum / n, glm::dvec3(0.0)) / (n - 1.0);
  return variance / n;
}

/// Standard deviation of one path over the square root of its cost: the optimal number of paths is proportional to it.
/// Source: Neyman 1934, "On the Two Different Aspects of the Representative Method" (with costs, Sec. 4).
inline float spread_of(const PixelSums& p) {
  if (p.count < 2) return 0.0f;
  const glm::dvec3 v = variance_of_mean(p);
  const double a_path = (v.x + v.y + v.z) / 3.0 * p.count;
  const double cost = std::max(static_cast<double>(p.rays) / p.count, 0.25);
  return static_cast<float>(std::sqrt(a_path / cost));
}

}  // namespace maquette
