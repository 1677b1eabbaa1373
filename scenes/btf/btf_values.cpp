#include "scenes/btf/btf_values.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numbers>

#include "scenes/error.h"
#include "scenes/srgb.h"

namespace maquette {

void BtfTask::check(const std::string& where) const {
  if (cancelled && cancelled()) throw Error(where, "was cancelled", "ask for it again");
}

float rho_of_value(bool cosine, const glm::dvec3& direction) {
  return static_cast<float>(1.0 / (std::numbers::pi * (cosine ? direction.z : 1.0)));
}

float linear_of_encoded(float value, double gamma) {
  const double v = std::max(0.0, static_cast<double>(value));
  if (gamma > 0.0) return static_cast<float>(std::pow(v, gamma));
  return static_cast<float>(linear_from_srgb(v));
}

void check_finite(const std::string& where, const std::string& what, const float* values, std::size_t count) {
  for (std::size_t i = 0; i < count; ++i)
    if (!std::isfinite(values[i]))
      throw Error(where, what + " has a value that is not finite (entry " + std::to_string(i) + ")", "export it again");
}

const BtfLights& BtfLightSets::find(const std::vector<glm::dvec3>& directions) {
  std::vector<double> key;
  for (const glm::dvec3& d : directions) key.insert(key.end(), {d.x, d.y, d.z});
  BtfLights& lights = sets_[key];
  if (!lights.mesh) lights = make_btf_lights(directions);
  return lights;
}

std::string btf_number(double x) {
  char text[32];
  std::snprintf(text, sizeof text, "%.6g", x);
  return text;
}

std::string btf_angles_text(const glm::dvec3& direction, char of) {
  constexpr double kDegrees = 180.0 / std::numbers::pi;
  const double theta = std::atan2(std::hypot(direction.x, direction.y), direction.z) * kDegrees;
  double phi = theta < 1e-6 ? 0.0 : std::atan2(direction.y, direction.x) * kDegrees;
  if (phi < -1e-9) phi += 360.0;
  char text[64];
  std::snprintf(text, sizeof text, "t%c%.4g p%c%.4g", of, std::round(theta * 1e3) / 1e3, of,
                std::abs(std::round(phi * 1e3) / 1e3));
  return text;
}

}  // namespace maquette
