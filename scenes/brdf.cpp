#include "scenes/brdf.h"

#include <algorithm>
#include <cmath>
#include <glm/gtc/constants.hpp>

namespace maquette {

namespace {

/// theta_h, theta_d in [0, pi/2], phi_d in [0, pi).
struct HalfAngles {
  double theta_h, theta_d, phi_d;
};

/// By definition: wi rotated into the frame whose z is the half vector.
/// Source: Rusinkiewicz 1998, Sec. 2 (rotation by -phi_h about the normal, then by -theta_h about the binormal).
HalfAngles half_angles(const glm::dvec3& wi, const glm::dvec3& wo) {
  const glm::dvec3 sum = wi + wo;
  const double length = glm::length(sum);
  const glm::dvec3 h = length > 0.0 ? sum / length : glm::dvec3(0.0, 0.0, 1.0);
  const double sin_h = std::hypot(h.x, h.y);
  const double theta_h = std::atan2(sin_h, h.z);
  const double cos_phi = sin_h > 0.0 ? h.x / sin_h : 1.0;
  const double sin_phi = sin_h > 0.0 ? h.y / sin_h : 0.0;
  const glm::dvec3 tangent(cos_phi * h.z, sin_phi * h.z, -sin_h);
  const glm::dvec3 binormal(-sin_phi, cos_phi, 0.0);
  // Half of wi - wo is the component of wi perpendicular to h, without cancellation.
  const glm::dvec3 across = 0.5 * (wi - wo);
  const double theta_d = std::atan2(glm::length(across), glm::dot(wi, h));
  double phi_d = std::atan2(glm::dot(across, binormal), glm::dot(across, tangent));
  if (phi_d < 0.0) phi_d += glm::pi<double>();
  if (phi_d >= glm::pi<double>()) phi_d -= glm::pi<double>();
  return {theta_h, theta_d, phi_d};
}

}  // namespace

glm::dvec3 evaluate_brdf(const BrdfTable& table, const glm::dvec3& wi, const glm::dvec3& wo) {
  if (wi.z <= 0.0 || wo.z <= 0.0) return glm::dvec3(0.0);
  const HalfAngles a = half_angles(wi, wo);
  const double half_pi = glm::half_pi<double>();
  const double x = std::clamp(kThetaHCount * std::sqrt(a.theta_h / half_pi) - 0.5, 0.0, kThetaHCount - 1.0);
  const double y = std::clamp(kThetaDCount * a.theta_d / half_pi - 0.5, 0.0, kThetaDCount - 1.0);
  double z = kPhiDCount * a.phi_d / glm::pi<double>() - 0.5;
  if (z < 0.0) z += kPhiDCount;
  const auto x0 = std::min(static_cast<std::size_t>(x), std::size_t{kThetaHCount - 2});
  const auto y0 = std::min(static_cast<std::size_t>(y), std::size_t{kThetaDCount - 2});
  const auto z0 = std::min(static_cast<std::size_t>(z), std::size_t{kPhiDCount - 1});
  const double fraction[3] = {x - static_cast<double>(x0), y - static_cast<double>(y0), z - static_cast<double>(z0)};
  glm::dvec3 value(0.0);
  for (std::size_t corner = 0; corner < 8; ++corner) {
    const std::size_t i = corner & 1, j = (corner >> 1) & 1, k = corner >> 2;
    const double weight = (i ? fraction[0] : 1.0 - fraction[0]) * (j ? fraction[1] : 1.0 - fraction[1]) *
                          (k ? fraction[2] : 1.0 - fraction[2]);
    const std::size_t phi = (z0 + k) % kPhiDCount;
    value += weight * glm::dvec3(table.rgb[phi + kPhiDCount * (y0 + j + kThetaDCount * (x0 + i))]);
  }
  return value;
}

}  // namespace maquette
