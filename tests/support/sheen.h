#pragma once

#include <cmath>
#include <glm/glm.hpp>
#include <numbers>

namespace maquette::test {

/// Masking of KHR_materials_sheen in double, as the extension writes it.
inline double sheen_lambda(double cosine, double alpha) {
  const double o = (1.0 - alpha) * (1.0 - alpha);
  const auto l = [&](double x) {
    const double a = std::lerp(21.5473, 25.3245, o), b = std::lerp(3.82987, 3.32435, o),
                 c = std::lerp(0.19823, 0.16801, o), d = std::lerp(-1.97760, -1.27393, o),
                 e = std::lerp(-4.32054, -4.85967, o);
    return a / (1.0 + b * std::pow(x, c)) + d * x + e;
  };
  return cosine < 0.5 ? std::exp(l(cosine)) : std::exp(2.0 * l(0.5) - l(1.0 - cosine));
}

/// The lobe of a white sheen, 1/sr.
inline double sheen_lobe(const glm::dvec3& wi, const glm::dvec3& wo, double alpha) {
  const glm::dvec3 h = glm::normalize(wi + wo);
  const double d = (2.0 + 1.0 / alpha) * std::pow(1.0 - h.z * h.z, 0.5 / alpha) / (2.0 * std::numbers::pi);
  return d / ((1.0 + sheen_lambda(wi.z, alpha) + sheen_lambda(wo.z, alpha)) * 4.0 * wi.z * wo.z);
}

}  // namespace maquette::test
